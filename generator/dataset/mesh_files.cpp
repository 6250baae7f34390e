#include "dataset/mesh_files.h"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr char kForeignPly[] = "is not a PLY file as ensonify writes it";
constexpr char kForeignGlb[] = "is not a binary glTF file as ensonify writes it";
constexpr char kWrongLength[] = "does not have the length that its header gives";

std::uint64_t size_of(const std::filesystem::path& path) {
  std::error_code unread;
  const std::uint64_t size = std::filesystem::file_size(path, unread);
  return unread ? 0 : size;
}

// The number at the end of a line; none if it begins otherwise.
std::optional<std::uint64_t> number_after(std::string_view line, std::string_view start) {
  if (!line.starts_with(start)) return std::nullopt;
  line.remove_prefix(start.size());
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
  const bool whole = error == std::errc() && end == line.data() + line.size();
  return whole ? std::optional(number) : std::nullopt;
}

struct Chunk {
  std::uint64_t bytes = 0;
  std::string kind;
};

// At the place of the file; none at its end.
std::optional<Chunk> chunk_at(std::ifstream& file, std::uint64_t place) {
  std::string head(8, '\0');
  file.seekg(static_cast<std::streamoff>(place));
  if (!file.read(head.data(), static_cast<std::streamsize>(head.size()))) return std::nullopt;
  return Chunk{value_at<std::uint32_t>(head, 0), head.substr(4)};
}

}  // namespace

std::string mesh_ply_fault(const std::filesystem::path& path) {
  // With the numbers of vertices and faces after the lines that end with a space.
  constexpr std::string_view kLines[] = {"ply",
                                         "format binary_little_endian 1.0",
                                         "element vertex ",
                                         "property double x",
                                         "property double y",
                                         "property double z",
                                         "element face ",
                                         "property list uchar int vertex_indices",
                                         "property ushort instance",
                                         "property uchar class",
                                         "end_header"};
  constexpr std::uint64_t kItemBytes[] = {3 * 8, 1 + 3 * 4 + 2 + 1};
  std::ifstream file(path, std::ios::binary);
  const std::uint64_t size = size_of(path);
  std::uint64_t expected = 0;
  const std::uint64_t* item_bytes = kItemBytes;
  for (const std::string_view wanted : kLines) {
    std::string line;
    while (std::getline(file, line) && line.starts_with("comment ")) {
    }
    if (!wanted.ends_with(' ')) {
      if (line != wanted) return kForeignPly;
      continue;
    }
    const auto count = number_after(line, wanted);
    if (!count || *count > size) return count ? kWrongLength : kForeignPly;
    expected += *count * *item_bytes++;
  }
  return file && static_cast<std::uint64_t>(file.tellg()) + expected == size ? "" : kWrongLength;
}

std::string glb_fault(const std::filesystem::path& path) {
  constexpr std::uint64_t kHead = 12, kChunkHead = 8;
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  if (!file.read(head.data(), static_cast<std::streamsize>(head.size()))) return kForeignGlb;
  const std::uint64_t size = size_of(path);
  if (!head.starts_with("glTF") || value_at<std::uint32_t>(head, 4) != 2) return kForeignGlb;
  if (value_at<std::uint32_t>(head, 8) != size) return kWrongLength;
  const auto text = chunk_at(file, kHead);
  if (!text || text->kind != "JSON") return kForeignGlb;
  std::uint64_t end = kHead + kChunkHead + text->bytes;
  if (const auto data = chunk_at(file, end)) {
    if (data->kind != std::string("BIN\0", 4)) return kForeignGlb;
    end += kChunkHead + data->bytes;
  }
  return end == size ? "" : kWrongLength;
}

}  // namespace ensonify
