#include "dataset/geometry_files.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/units.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr char kForeignPly[] = "is not a PLY file as ensonify writes it";
constexpr char kForeignGlb[] = "is not a binary glTF file as ensonify writes it";
constexpr char kWrongLength[] = "does not have the length that its header gives";

constexpr char kOpening[] =
    "ply\nformat binary_little_endian 1.0\ncomment meters in the world frame, z up\n"
    "element vertex ";
constexpr char kProperties[] =
    "property double x\nproperty double y\nproperty double z\n"
    "property float level_db\nproperty float range_m\n"
    "property float azimuth_rad\nproperty float elevation_rad\nproperty float cos_incidence\n"
    "property int beam\nproperty ushort instance\nproperty uchar class\nproperty ushort path\n"
    "end_header\n";

}  // namespace

std::string encode_points(const ScattererList& scatterers, const Pose& sonar_in_world,
                          double source_pressure_pa_m,
                          std::span<const std::uint8_t> class_of_instance) {
  std::string bytes = fmt::format("{}{}\n{}", kOpening, scatterers.size(), kProperties);
  const std::size_t header = bytes.size();
  bytes.resize(header + kPlyPointBytes * scatterers.size());
  char* at = bytes.data() + header;
  for (const Scatterer& s : scatterers.items) {
    const Vec3 world = transform_point(sonar_in_world, s.position_m);
    const double energy = std::norm(std::complex<double>(s.mean)) +
                          double{s.standard_deviation} * s.standard_deviation;
    ENSONIFY_ASSERT(s.instance < class_of_instance.size());
    put_value(at, world.x);
    put_value(at, world.y);
    put_value(at, world.z);
    const double peak_pa_per_m = source_pressure_pa_m * s.gain;
    put_value(at, level_db(peak_pa_per_m * peak_pa_per_m * energy));
    put_value(at, static_cast<float>(length(s.position_m)));
    put_value(at, s.arrival.azimuth_rad);
    put_value(at, s.arrival.elevation_rad);
    put_value(at, s.cos_incidence);
    put_value(at, static_cast<std::int32_t>(s.beam));
    put_value(at, static_cast<std::uint16_t>(s.instance));
    put_value(at, class_of_instance[s.instance]);
    put_value(at, s.path);
  }
  return bytes;
}

std::string ply_fault(const std::filesystem::path& path) {
  constexpr std::size_t kMost = sizeof kOpening + sizeof kProperties + 32;
  std::string start(kMost, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  const std::string_view opening = kOpening;
  if (!start.starts_with(opening)) return kForeignPly;
  std::uint64_t points = 0;
  const char* const from = start.data() + opening.size();
  const auto [end, error] = std::from_chars(from, start.data() + start.size(), points);
  const std::string header = fmt::format("{}{}\n{}", kOpening, points, kProperties);
  if (error != std::errc() || !start.starts_with(header)) {
    return kForeignPly;
  }
  std::error_code unread;
  const std::uint64_t size = std::filesystem::file_size(path, unread);
  return size == header.size() + points * kPlyPointBytes ? "" : kWrongLength;
}

namespace {

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

// The next line of at most 256 bytes; none if it is longer or does not end.
std::optional<std::string> short_line(std::ifstream& file) {
  std::string line(256, '\0');
  file.getline(line.data(), static_cast<std::streamsize>(line.size()));
  if (!file || file.eof()) return std::nullopt;
  line.resize(static_cast<std::size_t>(file.gcount()) - 1);
  return line;
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
    std::optional<std::string> line = short_line(file);
    while (line && line->starts_with("comment ")) line = short_line(file);
    if (!line) return kForeignPly;
    if (!wanted.ends_with(' ')) {
      if (*line != wanted) return kForeignPly;
      continue;
    }
    const auto count = number_after(*line, wanted);
    if (!count || *count > size) return count ? kWrongLength : kForeignPly;
    expected += *count * *item_bytes++;
  }
  return static_cast<std::uint64_t>(file.tellg()) + expected == size ? "" : kWrongLength;
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
