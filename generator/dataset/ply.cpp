#include "dataset/ply.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "core/error.h"
#include "core/units.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

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
  if (!start.starts_with(opening)) return "is not a PLY file as ensonify writes it";
  std::uint64_t points = 0;
  const char* const from = start.data() + opening.size();
  const auto [end, error] = std::from_chars(from, start.data() + start.size(), points);
  const std::string header = fmt::format("{}{}\n{}", kOpening, points, kProperties);
  if (error != std::errc() || !start.starts_with(header)) {
    return "is not a PLY file as ensonify writes it";
  }
  std::error_code unread;
  const std::uint64_t size = std::filesystem::file_size(path, unread);
  return size == header.size() + points * kPlyPointBytes
             ? ""
             : "does not have the length that its header gives";
}

}  // namespace ensonify
