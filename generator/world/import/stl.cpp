#include "world/import/stl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/counted.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr std::size_t kHeadBytes = 84, kFaceBytes = 50;

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The end of a binary file's last face, in bytes.
std::uint64_t binary_end(std::string_view bytes) {
  return kHeadBytes + std::uint64_t{kFaceBytes} * value_at<std::uint32_t>(bytes, 80);
}

bool is_letter(char c) { return (c | 0x20) >= 'a' && (c | 0x20) <= 'z'; }

bool is_word(std::string_view text, std::string_view word) {
  return std::equal(text.begin(), text.end(), word.begin(), word.end(),
                    [](char c, char small) { return (c | 0x20) == small; });
}

// Goes through the words of a text and makes the keywords small; `changed` if any was not.
Status read_words(const std::filesystem::path& file, std::string& text, bool& changed) {
  constexpr std::array<std::string_view, 9> kKeywords = {
      "vertex", "facet", "normal", "outer", "loop", "endloop", "endfacet", "solid", "endsolid"};
  std::uint64_t facets = 0, corners = 0;
  for (std::size_t at = 0; at < text.size();) {
    if (!is_letter(text[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && !is_blank(text[end])) ++end;
    const std::string_view found(text.data() + at, end - at);
    const auto word = std::find_if(kKeywords.begin(), kKeywords.end(),
                                   [&](std::string_view known) { return is_word(found, known); });
    const std::size_t begin = std::exchange(at, end);
    if (word == kKeywords.end()) continue;
    if (found != *word) {
      text.replace(begin, word->size(), *word);
      changed = true;
    }
    if (word->ends_with("solid")) {  // a name may follow
      at = std::min(text.find_first_of("\r\n", end), text.size());
    } else if (*word == "vertex") {
      ++corners;
    } else if (*word == "endfacet" && corners != 3) {
      return broken_mesh(file, fmt::format("facet {} has {}; expected 3: divide it into triangles "
                                           "before the export",
                                           facets, counted(corners, "corner")));
    } else if (*word == "endfacet") {
      ++facets;
      corners = 0;
    }
  }
  return {};
}

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= kHeadBytes && bytes.size() >= binary_end(bytes);
}

Status prepare_stl(const std::filesystem::path& file, std::string bytes, MeshBytes& prepared) {
  if (is_binary_stl(bytes)) {
    const std::uint64_t end = binary_end(bytes), more = bytes.size() - end;
    if (more == 0) return {};
    prepared.warnings.push_back(
        fmt::format("ignored {} behind the last of the {} that its head announces",
                    counted(more, "byte"), counted((end - kHeadBytes) / kFaceBytes, "face")));
    bytes.resize(end);
    prepared.changed = std::move(bytes);
    return {};
  }
  const auto begin = std::find_if_not(bytes.begin(), bytes.end(), is_blank);
  bool changed = begin != bytes.begin() || prepared.changed;
  bytes.erase(bytes.begin(), begin);
  if (Status sound = read_words(file, bytes, changed); !sound) return sound;
  if (!bytes.starts_with("solid")) {
    if (bytes.size() < kHeadBytes || bytes.find('\0') == std::string::npos) return {};
    return broken_mesh(file, fmt::format("its head announces {}, and it ends before the last; the "
                                         "file is cut off: copy or export it again",
                                         counted(value_at<std::uint32_t>(bytes, 80), "face")));
  }
  // An ASCII STL ends with endsolid; without this check, a file cut off between two facets would
  // pass as a smaller mesh.
  const std::size_t end = bytes.rfind("endsolid");
  const std::size_t behind = bytes.find_first_of("\r\n", end);  // the name, which may be any word
  if (end != std::string::npos &&
      (behind == std::string::npos || bytes.find("facet", behind) == std::string::npos)) {
    if (changed) prepared.changed = std::move(bytes);
    return {};
  }
  return broken_mesh(file, "ends without endsolid; the file is cut off: copy or export it again");
}

}  // namespace ensonify
