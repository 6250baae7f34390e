#include "cli/bench_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/units.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr char kFull[] = "full", kEnsemble[] = "speckle_wall";
constexpr char kSeriesOnly[] = "{polar: false, cartesian: false, png: false}";

struct SeriesCase {
  const char* name;
  std::vector<Override> overrides;
  std::vector<Override> compared;  // of TimedCase
};

//   full     512 beams x 114 rays, 60 m, b = 29.9 kHz, 90 deg: Choi et al. 2021 as released
//   table1   the same with b = 2.95 kHz: Table 1 as printed
//   reduced  512 beams x 11 rays, 10 m; nearer to the seabed, so that most rays meet it
//   dense    512 beams x (912 x 8) rays, 60 m
//   array    full, received by 256 elements at half a wavelength and focused at every sample
std::vector<SeriesCase> series_cases() {
  return {{"full", {}, {}},
          {"table1", {{"sonar.bandwidth_hz", "2950"}}, {}},
          {"reduced",
           {{"sonar.range_max_m", "10"},
            {"sonar.rays.elevation", "11"},
            {"trajectory.poses.0.position_m", "[0, -4, -1.5]"},
            {"trajectory.poses.1.position_m", "[0, 4, -1.5]"}},
           {}},
          {"dense",
           {{"sonar.rays", "{elevation: 912, azimuth: 8, min_per_cell: 0}"}},
           {{"sonar.rays", "{elevation: 114, azimuth: 2, min_per_cell: 0}"}}},
          {"array",
           {{"sonar.receiver", "{mode: array, elements: 256}"}},
           {{"sonar.rays.elevation", "2"}}}};
}

struct FileKind {
  const char* name;
  const char* output;  // YAML, the section `output` of the scenario
};

// Pixels of one view share their file of labels, so expected level and elevation have no row of
// their own. Files that only some scenarios have (channels, multipath masks, the distance field of
// a sequence) have no row either.
constexpr FileKind kFileKinds[] = {
    {"series", kSeriesOnly},
    {"series_exr", "{timeseries: both, polar: false, cartesian: false, png: false}"},
    {"polar", "{cartesian: false, png: false, shadow: false, amodal: false}"},
    {"polar_shadow", "{cartesian: false, png: false, amodal: false}"},
    {"polar_amodal", "{cartesian: false, png: false, shadow: false}"},
    {"polar_polygons",
     "{cartesian: false, png: false, shadow: false, amodal: false, polygons: true}"},
    {"polar_surfaces",
     "{cartesian: false, png: false, shadow: false, amodal: false, surfaces: true}"},
    {"polar_motion", "{cartesian: false, png: false, shadow: false, amodal: false, motion: true}"},
    {"cartesian",
     "{polar: false, cartesian: {exr: true}, png: false, shadow: false, amodal: false}"},
    {"png", "{polar: false, cartesian: false}"},
    {"scatterers", "{polar: false, cartesian: false, png: false, scatterers: true}"},
    {"points", "{polar: false, cartesian: false, png: false, points: true}"},
    {"front", "{polar: false, cartesian: false, png: false, front: true}"},
    {"elevation", "{polar: false, cartesian: false, png: false, elevation: true}"},
    {"layers", "{polar: false, cartesian: false, png: false, layers: true}"},
    {"default", "{}"},
    {"default_packed", "{one_file_per: sequence}"},
    {"every",
     "{timeseries: both, cartesian: {exr: true}, polygons: true, scatterers: true, points: true, "
     "layers: true, surfaces: true, motion: true, front: true, elevation: true}"}};

// Cartesian images have a fixed size, which would hide the growth of the rest.
const std::vector<Override>& keys_of_growth() {
  static const std::vector<Override> keys = {{"output", "{cartesian: false, png: false}"},
                                             {"sonar.beams.count", "128"}};
  return keys;
}

struct GrowthCases {
  const char* name;
  double BenchSizes::*grows;
  const char* key;
  std::vector<const char*> values;
};

// The spheres are in view of the sonar, so that each adds echoes and labels.
std::vector<GrowthCases> growth_cases() {
  return {{"beams", &BenchSizes::beams, "sonar.beams.count", {"128", "256", "512", "1024"}},
          {"samples",
           &BenchSizes::samples,
           "sonar.bandwidth_hz",
           {"14950", "29900", "59800", "119600"}},
          {"rays", &BenchSizes::rays, "sonar.rays.elevation", {"114", "342", "1026", "3078"}},
          {"objects", &BenchSizes::objects, "objects.10", {"64", "256", "1024", "4096"}},
          {"triangles",
           &BenchSizes::triangles,
           "objects.0.shape.heightfield.cell_m",
           {"0.62", "0.31", "0.155", "0.0775"}}};
}

// An object that is appended.
std::string spheres(const char* count) {
  return fmt::format(
      "{{name: stone, class: stone, count: {}, material: steel, shape: {{sphere: {{radius_m: "
      "0.3}}}}, pose: {{position_m: [{{uniform: [6, 55]}}, {{uniform: [-30, 30]}}, {{uniform: "
      "[-1.5, -0.5]}}]}}}}",
      count);
}

// As many beams as the sonar of `features`, equally spaced in the sine of the azimuth.
std::string unequal_beams() {
  constexpr int kBeams = 512;
  std::string text = fmt::format("{{count: {}, receive_width_deg: 1, azimuths_deg: [", kBeams);
  for (int j = 0; j < kBeams; ++j) {
    const double sine = std::sin(radians(45)) * (2.0 * j + 1 - kBeams) / kBeams;
    text += fmt::format("{}{:.4f}", j == 0 ? "" : ", ", degrees(std::asin(sine)));
  }
  return text + "]}";
}

struct Feature {
  const char* name;
  std::vector<Override> overrides;
};

// Settings of users' scenes, one at a time, over a plain one.
std::vector<Feature> features() {
  return {{"plain", {}},
          {"unequal_beams", {{"sonar.beams", unequal_beams()}}},
          {"motion_within_ping", {{"motion_within_ping", "true"}}},
          {"array", {{"sonar.receiver", "{mode: array}"}}},
          {"surface_speckle", {{"scattering.speckle", "surface"}}},
          {"surfaces", {{"output.surfaces", "true"}}},
          {"multipath", {{"multipath", "{surface: {z_m: 3, reflection: -1}}"}}},
          {"bounces", {{"bounces", "1"}}},
          {"refraction",
           {{"water.profile", "{depth_m: [0, 3, 10], sound_speed_m_s: [1504, 1500, 1499]}"}}},
          {"layers", {{"output.layers", "true"}}},
          {"volume", {{"volumes", "[{name: murk, class: water, uniform: {strength_db: -70}}]"}}}};
}

// The shipped sonar of the paper over a flat floor with a ball, with its default rays.
TimedGroup feature_group(const fs::path& full, int threads, std::uint32_t pings) {
  const std::vector<Override> plain = {
      {"sonar", "{preset: blueview_p900_90, range_max_m: 10, mount: {rotation_deg: [0, 20, 0]}}"},
      {"objects",
       "[{name: floor, class: seabed, material: sand, shape: {plane: {}}, pose: {position_m: [0, "
       "0, -2]}}, {name: ball, class: ball, material: steel, shape: {sphere: {radius_m: 0.4}}, "
       "pose: {position_m: [5, 0.5, -1.6]}}]"},
      {"trajectory.poses.1.time_s", "8"},
      {"output", "{cartesian: false, png: false}"}};
  TimedGroup group{"features", "a plain scene with one more feature each", nullptr, {}};
  for (Feature& feature : features()) {
    std::vector<Override> keys = plain;
    keys.insert(keys.end(), feature.overrides.begin(), feature.overrides.end());
    group.cases.push_back({feature.name, {full, std::move(keys)}, threads, pings});
  }
  return group;
}

// With more pings than other data sets, as a realization takes a fraction of a millisecond.
TimedGroup ensemble_group(const fs::path& wall, int threads) {
  constexpr std::uint32_t kMomentsAlone = 1000, kWithSeries = 200;
  constexpr char kKept[] = "{statistics: true, polar: false, cartesian: false, png: false}";
  return {"ensemble",
          "realizations of one scene",
          nullptr,
          {{"moments", {wall, {}}, threads, kMomentsAlone},
           {"series", {wall, {{"output", kKept}}}, threads, kWithSeries}}};
}

TimedGroup growth_with_threads(const fs::path& full, int threads) {
  TimedGroup group{"threads", "growth with threads", &BenchSizes::threads, {}};
  const auto add = [&](int count) {
    group.cases.push_back({std::to_string(count),
                           {full, keys_of_growth()},
                           count,
                           static_cast<std::uint32_t>(std::max(8, 4 * count))});
  };
  for (int count = 1; count < threads; count *= 2) add(count);
  add(threads);
  return group;
}

TimedGroup growth_with_size(const GrowthCases& cases, const fs::path& full, int threads) {
  constexpr std::uint32_t kPings = 8;
  TimedGroup group{cases.name, fmt::format("growth with {}", cases.name), cases.grows, {}};
  for (const char* value : cases.values) {
    std::vector<Override> keys = keys_of_growth();
    keys.push_back({cases.key, cases.grows == &BenchSizes::objects ? spheres(value) : value});
    group.cases.push_back({value, {full, std::move(keys)}, threads, kPings});
  }
  return group;
}

}  // namespace

Status write_bench_files(const fs::path& folder) {
  const auto write = [&](const std::string& name, const char* text) -> Status {
    const auto written = write_file_atomically(folder, name, text);
    return written ? Status() : Status(written.error());
  };
  for (const EmbeddedMesh& mesh : bench_meshes()) {
    if (Status s = write(fmt::format("meshes/{}.obj", mesh.name), mesh.text); !s) return s;
  }
  for (const EmbeddedScenario& scenario : bench_scenarios()) {
    if (Status s = write(fmt::format("{}.yaml", scenario.name), scenario.text); !s) return s;
  }
  return {};
}

std::vector<TimedGroup> bench_groups(const fs::path& folder, int threads, std::uint32_t pings) {
  const fs::path full = folder / "full.yaml";
  TimedGroup series{"series", "time series alone, compared with the reference", nullptr, {}};
  for (SeriesCase& c : series_cases()) {
    std::vector<Override> keys = {{"output", kSeriesOnly}};
    keys.insert(keys.end(), c.overrides.begin(), c.overrides.end());
    series.cases.push_back({c.name, {full, keys}, threads, pings, std::move(c.compared)});
  }
  TimedGroup files{"files", "one scenario by kinds of files", nullptr, {}};
  for (const FileKind& kind : kFileKinds) {
    files.cases.push_back({kind.name, {full, {{"output", kind.output}}}, threads, pings});
  }
  TimedGroup scenes{"scenes", "shipped scenes with their own files", nullptr, {}};
  for (const EmbeddedScenario& scenario : bench_scenarios()) {
    const std::string_view name = scenario.name;
    if (name == kFull || name == kEnsemble) continue;
    const fs::path file = folder / fmt::format("{}.yaml", scenario.name);
    scenes.cases.push_back({scenario.name, {file, {}}, threads, pings});
  }
  std::vector<TimedGroup> groups = {std::move(series),
                                    std::move(files),
                                    std::move(scenes),
                                    feature_group(full, threads, pings),
                                    ensemble_group(folder / "speckle_wall.yaml", threads),
                                    growth_with_threads(full, threads)};
  for (const GrowthCases& cases : growth_cases()) {
    groups.push_back(growth_with_size(cases, full, threads));
  }
  return groups;
}

}  // namespace ensonify
