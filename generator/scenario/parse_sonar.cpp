#include <cmath>

#include <fmt/format.h>

#include "scenario/merge.h"
#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr int kMaxRays = 1'000'000;
constexpr int kMaxPerCell = 1000;

// Larger pings would take more than 2 GiB for one stage alone, or run for days.
constexpr double kMaxPixels = 268435456.0;     // 2^28 beams x samples
constexpr double kMaxSonarRays = 134217728.0;  // 2^27 beams x rays

void set_source(Node& node, int source) {
  node.place.source = source;
  for (Key& key : node.keys) key.place.source = source;
  for (Node& item : node.items) set_source(item, source);
}

// The preset that the map names, as a tree; nothing if it names none.
std::optional<Node> preset_tree(Faults& faults, const Value& sonar) {
  std::vector<std::string_view> names;
  for (const SonarPreset& preset : sonar_presets()) names.push_back(preset.name);
  const auto index = read_word(faults, sonar, "preset", names, Need::optional);
  if (!index) return std::nullopt;
  Node tree = preset_trees()[*index];
  set_source(tree, add_source(faults, "preset " + sonar_presets()[*index].name));
  return tree;
}

void parse_elevation(Faults& faults, const Value& elevation, Need need, SonarSpec& sonar) {
  if (!open_map(faults, elevation, {"width_deg", "fan_deg"})) return;
  read_number(faults, elevation, "width_deg", kAngle, sonar.elevation_width_deg, need);
  sonar.elevation_fan_deg = sonar.elevation_width_deg;
  read_number(faults, elevation, "fan_deg", kAngle, sonar.elevation_fan_deg);
}

void parse_rays(Faults& faults, const Value& rays, Need need, SonarSpec& sonar) {
  if (!open_map(faults, rays, {"elevation", "azimuth", "per_cell"})) return;
  read_integer(faults, rays, "elevation", 1, kMaxRays, sonar.rays_elevation, need);
  read_integer(faults, rays, "azimuth", 1, kMaxRays, sonar.rays_azimuth);
  read_integer(faults, rays, "per_cell", 0, kMaxPerCell, sonar.rays_per_cell);
}

void check_band(Faults& faults, const Value& map, const SonarSpec& sonar) {
  const auto frequency = child(map, "frequency_hz");
  const auto bandwidth = child(map, "bandwidth_hz");
  if (!frequency || !bandwidth || sonar.frequency_hz == 0 || sonar.bandwidth_hz == 0) return;
  if (sonar.frequency_hz > sonar.bandwidth_hz / 2) return;
  const Value culprit = blamed(*bandwidth, *frequency);
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("a band of {} Hz around {} Hz reaches below zero, accepted is a "
                        "bandwidth_hz of less than twice frequency_hz",
                        sonar.bandwidth_hz, sonar.frequency_hz));
}

void check_ranges(Faults& faults, const Value& map, const SonarSpec& sonar) {
  const auto far = child(map, "range_max_m");
  const auto near = child(map, "range_min_m");
  if (!far || sonar.range_max_m == 0 || sonar.range_max_m > sonar.range_min_m) return;
  const Value culprit = near ? blamed(*far, *near) : *far;
  add_fault(faults, culprit.place, culprit.path,
            fmt::format("range_min_m {} is not below range_max_m {}, accepted is "
                        "0 <= range_min_m < range_max_m",
                        sonar.range_min_m, sonar.range_max_m));
}

}  // namespace

Value blamed(const Value& value, const Value& other) {
  return other.place.source < value.place.source ? other : value;
}

void parse_sonar(const InputFolder& input, const Value& value, SonarSpec& sonar) {
  Faults& faults = input.faults;
  const std::vector<std::string_view> keys = {
      "preset",      "frequency_hz", "bandwidth_hz", "pulse",     "window", "source_level_db",
      "range_min_m", "range_max_m",  "beams",        "elevation", "rays",   "receiver",
      "mount"};
  if (!open_map(faults, value, keys)) return;
  const std::optional<Node> preset = preset_tree(faults, value);
  const Node merged = preset ? merge_over(*preset, *value.node) : *value.node;
  const Value map{&merged, value.place, value.path};
  // A preset that is not known would have set the rest: one fault is enough.
  const Need need = child(value, "preset") && !preset ? Need::optional : Need::required;
  if (need == Need::required && !preset && !child(map, "frequency_hz")) {
    add_fault(faults, value.place, path_of(value, "preset"),
              "missing, and so is frequency_hz; accepted is a preset (`ensonify presets` lists "
              "them), or every key named here");
  }
  read_number(faults, map, "frequency_hz", above_up_to(0, 1e9), sonar.frequency_hz, need);
  read_number(faults, map, "bandwidth_hz", above_up_to(0, 1e9), sonar.bandwidth_hz, need);
  parse_pulse(input, map, sonar.pulse);
  read_choice<Window>(faults, map, "window",
                      {{"none", Window::none},
                       {"hann", Window::hann},
                       {"hamming", Window::hamming},
                       {"blackman", Window::blackman}},
                      sonar.window);
  read_number(faults, map, "source_level_db", kLevelDb, sonar.source_level_db, need);
  read_number(faults, map, "range_min_m", from_to(0, kMaxLengthM), sonar.range_min_m);
  read_number(faults, map, "range_max_m", above_up_to(0, kMaxLengthM), sonar.range_max_m, need);
  parse_beams(faults, child_or_empty(map, "beams"), need, sonar);
  parse_elevation(faults, child_or_empty(map, "elevation"), need, sonar);
  parse_rays(faults, child_or_empty(map, "rays"), need, sonar);
  if (const auto v = child(map, "receiver")) parse_receiver(faults, *v, sonar);
  if (const auto mount = child(map, "mount"); mount && open_map(faults, *mount, kPoseKeys)) {
    parse_pose(faults, *mount, sonar.mount);
  }
  check_band(faults, map, sonar);
  check_pulse_band(faults, map, sonar);
  check_ranges(faults, map, sonar);
}

void check_ping_size(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto value = child(root, "sonar");
  if (!value) return;
  const SonarSpec& sonar = scenario.sonar;
  const double samples =
      std::ceil(sonar.bandwidth_hz * 2 * sonar.range_max_m / scenario.water.sound_speed_m_s);
  if (sonar.beam_count * samples > kMaxPixels) {
    add_fault(faults, value->place, value->path,
              fmt::format("{} beams of {} samples are more than 2^28 (268435456) a ping; lower "
                          "beams.count, range_max_m or bandwidth_hz",
                          sonar.beam_count, samples));
  }
  const double rays = double{1} * sonar.beam_count * sonar.rays_elevation * sonar.rays_azimuth;
  if (rays > kMaxSonarRays) {
    add_fault(faults, value->place, value->path,
              fmt::format("{} beams of {} x {} rays are more than 2^27 (134217728) a ping; lower "
                          "rays.elevation, rays.azimuth or beams.count",
                          sonar.beam_count, sonar.rays_elevation, sonar.rays_azimuth));
  }
}

}  // namespace ensonify
