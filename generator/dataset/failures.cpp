#include "dataset/failures.h"

#include <algorithm>
#include <system_error>

#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

void add_numbers(const fs::path& folder, std::vector<std::uint32_t>& numbers) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() < 6 || name.size() > 10) continue;
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto number = std::stoull(name);
    if (number <= UINT32_MAX) numbers.push_back(static_cast<std::uint32_t>(number));
  }
}

std::optional<std::string> recorded_failure(const fs::path& dir, std::uint32_t sequence) {
  const std::string path = layout::failure_path(sequence);
  if (!listed_file_size(dir, path)) return std::nullopt;
  const auto text = read_file(dir / path);
  const auto json = text ? parse_json(*text) : std::nullopt;
  if (!json || count_at(*json, "sequence") != sequence) return std::nullopt;
  const Json* error = member(*json, "error");
  if (error == nullptr || !error->is_string()) return std::nullopt;
  return error->get<std::string>();
}

}  // namespace

std::vector<std::uint32_t> sequence_numbers(const fs::path& dir) {
  std::vector<std::uint32_t> numbers;
  add_numbers(dir / "sequences", numbers);
  add_numbers(dir / layout::kWorkFolder / "sequences", numbers);
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

Failures failures_in(const fs::path& dir) {
  Failures failures;
  if (listed_file_size(dir, layout::kDatasetJson)) {
    const auto head = parse_manifest_file(dir / layout::kDatasetJson, [](const FileEntry&) {});
    const auto manifest = head ? read_dataset_head(*head) : std::nullopt;
    if (manifest) {
      for (const auto& [sequence, error] : manifest->failed) failures.emplace(sequence, error);
    }
  }
  std::vector<std::uint32_t> numbers;
  add_numbers(dir / layout::kWorkFolder / "sequences", numbers);
  for (const std::uint32_t sequence : numbers) {
    if (auto error = recorded_failure(dir, sequence)) failures.emplace(sequence, std::move(*error));
  }
  return failures;
}

Status record_failure(const fs::path& dir, const SequenceFailure& failure) {
  const Json json = {{"sequence", failure.sequence}, {"error", failure.error}};
  const auto written =
      write_file_atomically(dir, layout::failure_path(failure.sequence), json_text(json));
  return written ? Status() : Status(written.error());
}

}  // namespace ensonify
