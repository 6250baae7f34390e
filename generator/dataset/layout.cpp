#include "dataset/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "dataset/catalogue.h"

namespace ensonify::layout {
namespace {

constexpr std::string_view kPingMark = "{ping}";
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Replaces every run of six or more digits by {ping}.
std::string with_marks(std::string_view name) {
  std::string marked;
  for (std::size_t i = 0; i < name.size();) {
    std::size_t end = i;
    while (end < name.size() && is_digit(name[end])) ++end;
    if (end - i >= 6) {
      marked += kPingMark;
      i = end;
    } else {
      marked += name[i++];
    }
  }
  return marked;
}

// Whether `name` is `candidate` or one of the folders above it.
bool is_or_holds(std::string_view name, std::string_view candidate) {
  return candidate == name ||
         (candidate.size() > name.size() && candidate.substr(0, name.size()) == name &&
          candidate[name.size()] == '/');
}

}  // namespace

std::string sequence_folder(std::uint32_t sequence) {
  return fmt::format("sequences/{:06}", sequence);
}
std::string in_sequence(std::uint32_t sequence, std::string_view name) {
  return fmt::format("sequences/{:06}/{}", sequence, name);
}
std::string ping_stem(std::uint32_t ping) { return fmt::format("{:06}", ping); }
std::string index_stem(std::uint32_t sequence, std::uint32_t ping) {
  return fmt::format("{:06}/{:06}", sequence, ping);
}

std::string ping_file(std::string_view name_template, std::uint32_t ping) {
  std::string name(name_template);
  const auto at = name.find(kPingMark);
  if (at != std::string::npos) name.replace(at, kPingMark.size(), ping_stem(ping));
  return name;
}

std::optional<PingFile> parse_ping_file(std::string_view name) {
  const std::string marked = with_marks(name);
  const auto at = marked.find(kPingMark);
  if (at == std::string::npos) return std::nullopt;
  PingFile file{marked, 0};
  // No digits are replaced before the mark, so its position in the name is the same.
  std::from_chars(name.data() + at, name.data() + name.size(), file.ping);
  if (ping_file(file.name_template, file.ping) != name) return std::nullopt;
  return file;
}

std::string record_path(std::uint32_t sequence, std::uint32_t ping) {
  return fmt::format("{}/sequences/{:06}/{:06}.json", kWorkFolder, sequence, ping);
}
std::string plan_path(std::uint32_t sequence) {
  return fmt::format("{}/sequences/{:06}/plan.json", kWorkFolder, sequence);
}
std::string failure_path(std::uint32_t sequence) {
  return fmt::format("{}/sequences/{:06}/failure.json", kWorkFolder, sequence);
}
std::string top_plan_path() { return fmt::format("{}/plan.json", kWorkFolder); }

bool is_layout_name(std::string_view relative) {
  for (const char* folder : {"assets", kWorkFolder, kRenders}) {
    if (is_or_holds(folder, relative)) return true;
  }
  const std::string marked = with_marks(relative);
  const auto in_sequence_folder = [&](std::string_view name) {
    return is_or_holds(marked, "sequences/{ping}/" + std::string(name));
  };
  const auto rows = catalogue();
  return in_sequence_folder(kPiece) ||
         std::any_of(rows.begin(), rows.end(), [&](const CatalogueRow& row) {
           if (row.scope == FileScope::dataset) return is_or_holds(relative, row.file);
           return in_sequence_folder(row.file) ||
                  (!row.array.empty() && in_sequence_folder(row.array));
         });
}

}  // namespace ensonify::layout
