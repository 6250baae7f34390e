#include "dataset/sample.h"

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <type_traits>

#include "catch.h"
#include "core/front_planes.h"
#include "core/units.h"
#include "dataset/write_ping.h"
#include "results.h"

namespace ensonify::sample {
namespace fs = std::filesystem;

SequenceInfo sequence_info(std::uint32_t sequence) {
  SequenceInfo info;
  info.sequence = sequence;
  info.seed = 18446744073709551615u;  // does not fit a double or a signed integer
  info.split = sequence % 2 == 0 ? "train" : "val";
  info.sonar.frequency_hz = 900e3;
  info.sonar.bandwidth_hz = 29.9e3;
  info.sonar.source_level_db = 220;
  info.sonar.range_max_m = kSamples * 1500 / (2 * 29.9e3);
  info.sonar.beam_count = kBeams;
  info.sonar.beam_spacing_rad = 0.3;
  info.sonar.beam_width_rad = 0.02;
  info.receive_aperture_wavelengths = 44;
  info.sonar.elevation_width_rad = info.sonar.elevation_fan_rad = 0.3;
  info.sonar.elevation_line.aperture = 2.9;
  info.sonar.rays_elevation = 3;
  info.record = {kSamples, 128, 1 / 29.9e3};
  info.noise_spectrum_level_db = 30;
  info.noise_power_pa2 = 2.99e-5;
  info.instances.resize(2);
  Instance& wall = info.instances[0];
  wall.id = 1;
  wall.name = "wall";
  wall.class_id = 1;
  wall.class_name = "structure";
  wall.material = "concrete";
  wall.scattering.reflectivity = 1e-3;
  wall.box = OrientedBox{{{1, 0, 0}, {}}, {2, 4, 6}};
  Instance& target = info.instances[1];
  target.id = 2;
  target.name = "target";
  target.class_id = 2;
  target.class_name = "cylinder";
  target.kind = InstanceKind::point_target;
  target.target_strength_db = -40;
  info.classes = {"structure", "cylinder"};
  info.cartesian = CartesianGrid{7, 8, 0.03, 0.21, 0.12};
  info.output.scatterers = info.output.points = info.output.polygons = true;
  info.output.timeseries_exr = info.output.cartesian_exr = true;
  info.last_ping = kPings;
  return info;
}

namespace {

// Other values in each plane; every fifth pixel hears nothing, and is in a shadow.
template <class Value>
Value plane_value(const ImagePlane& plane, int i, int variant) {
  const auto number = static_cast<int>(&plane - std::begin(kImagePlanes));
  const bool none = i % 5 == 0;
  if constexpr (std::is_floating_point_v<Value>) {
    if (none) return blank_value<Value>(plane.blank);
    if (plane.blank == PlaneBlank::no_energy) {
      return static_cast<Value>(80 - 10 * number + i + (is_level_plane(plane) ? variant : 0));
    }
    if (plane.blank == PlaneBlank::nan) return 0.03f * static_cast<Value>(i) / Value(number + 1);
    return 1 / static_cast<Value>(number + 1);
  } else {
    if (plane.wanted != nullptr) return static_cast<Value>(none ? 300 : 0);
    return static_cast<Value>(none ? 0 : i % 3 * (sizeof(Value) > 1 ? 300 : 1));
  }
}

}  // namespace

LabelledImage image(int rows, int columns, int variant, const OutputSelection& output) {
  LabelledImage image;
  image.rows = rows;
  image.columns = columns;
  for (const ImagePlane& plane : kImagePlanes) {
    if (!has_plane(output, plane)) continue;
    with_plane(image, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      for (int i = 0; i < rows * columns; ++i) {
        values.push_back(plane_value<Value>(plane, i, variant));
      }
    });
  }
  return image;
}

bool has_plane(const OutputSelection& output, const ImagePlane& plane) {
  return plane.wanted == nullptr || output.*plane.wanted;
}

namespace {

// Other values in each plane; every fourth pixel meets nothing.
FrontView front_view(const SequenceInfo& info, int variant) {
  FrontView view;
  view.rows = info.sonar.rays_elevation;
  view.columns = info.sonar.beam_count * info.sonar.rays_azimuth;
  for (const FrontPlane& plane : kFrontPlanes) {
    const auto number = static_cast<int>(&plane - std::begin(kFrontPlanes));
    with_plane(view, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      for (int i = 0; i < view.rows * view.columns; ++i) {
        values.push_back(i % 4 == 0 ? blank_value<Value>(plane.blank)
                                    : static_cast<Value>(1 + (i + number + variant) % 2));
      }
    });
  }
  return view;
}

GreyImage grey(int rows, int columns, int variant) {
  GreyImage picture{rows, columns, {}};
  for (int i = 0; i < rows * columns; ++i) {
    picture.pixels.push_back(static_cast<std::uint8_t>(37 * i + variant));
  }
  return picture;
}

}  // namespace

PingResult ping_result(const SequenceInfo& info, std::uint32_t ping) {
  PingResult result;
  const int variant = static_cast<int>(10 * info.sequence + ping);
  result.ping = ping;
  result.time_s = 0.1 * ping;
  result.sonar_in_world = {{1.0 / 3 + ping, 2, -3}, from_roll_pitch_yaw(0, 0, kPi / 2)};
  result.object_in_world = {Pose{}, {{4, 0, 0.5 * ping}, {}}};
  for (int i = 0; i < kBeams * kSamples; ++i) {
    result.series.emplace_back(static_cast<float>(i), static_cast<float>(variant));
  }
  result.polar = image(kSamples, kBeams, variant, info.output);
  result.cartesian =
      image(info.cartesian->height_px, info.cartesian->width_px, variant, info.output);
  if (info.output.front) result.front = front_view(info, variant);
  result.polar_grey = grey(kSamples, kBeams, variant);
  result.grey_counts = {kSamples * kBeams, 1, 40, 2 + ping};
  result.cartesian_grey = grey(info.cartesian->height_px, info.cartesian->width_px, variant);
  // Runs 0 0 54: every pixel of 9 x 6, as COCO's tools write it.
  result.polar_annotations = {{2, {0, 0, kBeams, kSamples}, kBeams * kSamples, "0f1"}};
  result.polar_annotations[0].measures = {0.125, 6.02};
  result.polar_annotations[0].amodal = {{0, 0, kBeams, kSamples}, kBeams * kSamples, "0f1"};
  // Of 7 x 8: runs 7 3 4 3 39; 0 1 55. The first goes on, hidden, by a column: 7 3 4 3 4 3 32.
  result.cartesian_annotations = {{1, {1, 0, 2, 3}, 6, "7340S1"}, {2, {0, 0, 1, 1}, 1, "01g1"}};
  result.cartesian_annotations[0].amodal = {{1, 0, 3, 3}, 9, "734000l0"};
  result.cartesian_annotations[0].occlusion = 0.25;
  result.cartesian_annotations[1].amodal = {{0, 0, 1, 1}, 1, "01g1"};
  result.cartesian_annotations[1].occlusion = std::numeric_limits<double>::quiet_NaN();
  // Runs 0 1 53 of 9 x 6.
  result.polar_hidden = {{1, {}, 0, {}, PixelMask{{0, 0, 1, 1}, 1, "01e1"}, 1}};
  for (int j = 0; j < kBeams; ++j) {
    result.first_return_m.push_back(j == 2 ? std::numeric_limits<float>::quiet_NaN()
                                           : 0.1f + static_cast<float>(j));
  }
  Scatterer near{};
  near.delay_s = 1e-3;
  near.position_m = {0.75, 0.25, -0.5};
  near.arrival = {0.05f, -0.1f};
  near.gain = 0.5f;
  near.mean = {0.1f, 0.2f};
  near.standard_deviation = 3;
  near.cos_incidence = 0.9f;
  near.doppler = 1e-4f;
  near.beam = 3;
  near.instance = 2;
  near.path = 1;
  Scatterer far = near;
  far.delay_s = 2e-3;
  result.scatterers = sorted_by_beam_and_delay({far, near}, kBeams);
  result.amplitudes = {{1, 2}, {3, 4}};
  return result;
}

std::vector<std::int32_t> cartesian_map(const SequenceInfo& info) {
  std::vector<std::int32_t> map;
  for (int i = 0; i < info.cartesian->height_px * info.cartesian->width_px; ++i) {
    map.push_back(i % 3 == 0 ? -1 : 7 * i % (kSamples * kBeams));
  }
  return map;
}

Status finish(const fs::path& dir, const SequenceInfo& info) {
  const std::vector<std::int32_t> map = cartesian_map(info);
  return ensonify::finish_sequence(dir, info, {.cartesian_map = map});
}

WorkIdentity identity() {
  return {"tank", std::string(64, 'a'), 7, 0, kPings, "0.1.0", "abcdef", "cpu", "avx2", "AVX2"};
}

DatasetInfo dataset_info(std::uint32_t sequences) {
  DatasetInfo info;
  info.identity = identity();
  info.scenario_yaml = "ensonify: 1\nsequences: " + std::to_string(sequences) + "\n";
  for (std::uint32_t s = 0; s < sequences; ++s) info.sequences.push_back(s);
  info.first = sequence_info(0);
  info.classes = info.first.classes;
  info.class_kinds = {ClassKind::stuff, ClassKind::thing};
  info.host = "somewhere";
  info.threads = 2;
  return info;
}

void open(const fs::path& dir, std::uint32_t sequences) {
  value_of(open_work(dir, identity(), sequences, false));
}

void write_pings(const fs::path& dir, const SequenceInfo& info) {
  const Workers workers(2);
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    if (ping_is_finished(dir, info.sequence, ping, info)) continue;
    require_ok(write_ping(dir, info, ping_result(info, ping), workers));
  }
}

void make_dataset(const fs::path& dir, std::uint32_t sequences) {
  open(dir, sequences);
  const DatasetInfo info = dataset_info(sequences);
  for (const std::uint32_t number : info.sequences) {
    const SequenceInfo sequence = sequence_info(number);
    write_pings(dir, sequence);
    require_ok(finish(dir, sequence));
  }
  require_ok(finish_dataset(dir, info));
}

std::map<std::string, std::string> contents(const fs::path& dir) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(dir)) {
    const auto name = entry.path().lexically_relative(dir).generic_string();
    if (!entry.is_directory() && name != "provenance.json") files[name] = read(entry.path());
  }
  return files;
}

std::string read(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  REQUIRE(stream.good());
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << bytes;
  REQUIRE(stream.good());
}

void flip_bit(const fs::path& file, std::size_t byte, int bit) {
  std::string bytes = read(file);
  REQUIRE(byte < bytes.size());
  bytes[byte] = static_cast<char>(bytes[byte] ^ (1 << bit));
  write(file, bytes);
}

}  // namespace ensonify::sample
