#include <cmath>

#include <fmt/format.h>

#include "scenario/merge.h"
#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr NumberRange kAngle = above_up_to(0, 180);
constexpr NumberRange kLevelDb = from_to(-300, 400);
constexpr int kMaxBeams = 65536;
constexpr int kMaxRays = 1'000'000;

// Larger pings would take more than 2 GiB for one stage alone, or run for days.
constexpr double kMaxPixels = 268435456.0;     // 2^28 beams x samples
constexpr double kMaxSonarRays = 134217728.0;  // 2^27 beams x rays

// The preset that the map names, as a tree; nothing if it names none.
std::optional<Node> preset_tree(Faults& faults, const Value& sonar) {
  std::vector<std::string_view> names;
  for (const SonarPreset& preset : sonar_presets()) names.push_back(preset.name);
  const auto index = read_word(faults, sonar, "preset", names, Need::optional);
  if (!index) return std::nullopt;
  const SonarPreset& preset = sonar_presets()[*index];
  const int source = add_source(faults, "preset " + preset.name);
  return read_yaml_map(preset.yaml, source, faults);
}

void parse_beams(Faults& faults, const Value& beams, Need need, SonarSpec& sonar) {
  if (!open_map(faults, beams, {"count", "spacing_deg", "fov_deg", "width_deg"})) return;
  const bool counted = read_integer(faults, beams, "count", 1, kMaxBeams, sonar.beam_count, need);
  read_number(faults, beams, "width_deg", kAngle, sonar.beam_width_deg, need);
  const bool either = child(beams, "spacing_deg") || child(beams, "fov_deg");
  if (!either) {
    if (need == Need::optional) return;
    add_fault(faults, beams.place, path_of(beams, "fov_deg"),
              fmt::format("missing, accepted is {}, or spacing_deg, which is that divided by count",
                          in_words(kAngle, "number")));
    return;
  }
  const auto key = only_key_of(faults, beams, {"spacing_deg", "fov_deg"},
                               "either alone: spacing_deg, or fov_deg, which is that times count");
  if (!key) return;
  double angle = 0;
  if (!read_number(faults, beams, *key, kAngle, angle)) return;
  if (*key == "fov_deg") {
    sonar.beam_fov_deg = angle;
    return;
  }
  const double fov = angle * sonar.beam_count;
  if (counted && fov > kAngle.high) {
    add_fault(faults, child(beams, "spacing_deg")->place, path_of(beams, "spacing_deg"),
              fmt::format("{} beams of {} degrees span {} degrees, at most 180 are accepted",
                          sonar.beam_count, angle, fov));
    return;
  }
  sonar.beam_fov_deg = fov;
}

void parse_elevation(Faults& faults, const Value& elevation, Need need, SonarSpec& sonar) {
  if (!open_map(faults, elevation, {"width_deg", "fan_deg"})) return;
  read_number(faults, elevation, "width_deg", kAngle, sonar.elevation_width_deg, need);
  sonar.elevation_fan_deg = sonar.elevation_width_deg;
  read_number(faults, elevation, "fan_deg", kAngle, sonar.elevation_fan_deg);
}

void parse_rays(Faults& faults, const Value& rays, Need need, SonarSpec& sonar) {
  if (!open_map(faults, rays, {"elevation", "azimuth"})) return;
  read_integer(faults, rays, "elevation", 1, kMaxRays, sonar.rays_elevation, need);
  read_integer(faults, rays, "azimuth", 1, kMaxRays, sonar.rays_azimuth);
}

// Of two values that contradict each other, the one that the user wrote.
Value blamed(const Value& value, const Value& other) {
  return other.place.source < value.place.source ? other : value;
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

void parse_sonar(Faults& faults, const Value& value, SonarSpec& sonar) {
  const std::vector<std::string_view> keys = {
      "preset",          "frequency_hz", "bandwidth_hz", "pulse",
      "source_level_db", "range_min_m",  "range_max_m",  "beams",
      "elevation",       "rays",         "mount"};
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
  read_choice<PulseShape>(faults, map, "pulse",
                          {{"gaussian", PulseShape::gaussian}, {"flat", PulseShape::flat}},
                          sonar.pulse.shape);
  read_number(faults, map, "source_level_db", kLevelDb, sonar.source_level_db, need);
  read_number(faults, map, "range_min_m", from_to(0, kMaxLengthM), sonar.range_min_m);
  read_number(faults, map, "range_max_m", above_up_to(0, kMaxLengthM), sonar.range_max_m, need);
  parse_beams(faults, child_or_empty(map, "beams"), need, sonar);
  parse_elevation(faults, child_or_empty(map, "elevation"), need, sonar);
  parse_rays(faults, child_or_empty(map, "rays"), need, sonar);
  if (const auto mount = child(map, "mount"); mount && open_map(faults, *mount, kPoseKeys)) {
    parse_pose(faults, *mount, sonar.mount);
  }
  check_band(faults, map, sonar);
  check_ranges(faults, map, sonar);
}

// A number, or {from: {temperature_c, salinity_psu, depth_m}}.
void parse_sound_speed(Faults& faults, const Value& water_value, WaterSpec& water) {
  const auto speed = child(water_value, "sound_speed_m_s");
  if (!speed || speed->node->kind != NodeKind::map) {
    read_number(faults, water_value, "sound_speed_m_s", from_to(100, 10000), water.sound_speed_m_s);
    return;
  }
  if (!open_map(faults, *speed, {"from"})) return;
  const Value from = child_or_empty(*speed, "from");
  if (!open_map(faults, from, {"temperature_c", "salinity_psu", "depth_m"})) return;
  SoundSpeedSpec spec;
  read_number(faults, from, "temperature_c", from_to(-5, 40), spec.temperature_c, Need::required);
  read_number(faults, from, "salinity_psu", from_to(0, 45), spec.salinity_psu, Need::required);
  read_number(faults, from, "depth_m", from_to(0, 12000), spec.depth_m, Need::required);
  water.sound_speed_from = spec;
}

void parse_water(Faults& faults, const Value& value, WaterSpec& water) {
  if (!open_map(faults, value, {"sound_speed_m_s", "absorption"})) return;
  parse_sound_speed(faults, value, water);
  const auto absorption = child(value, "absorption");
  if (!absorption) return;
  if (!open_map(faults, *absorption,
                {"fixed_db_m", "model", "temperature_c", "salinity_psu", "ph", "depth_m"})) {
    return;
  }
  const auto key = only_key_of(faults, *absorption, {"fixed_db_m", "model"},
                               "fixed_db_m (dB/m) or model (francois_garrison, ainslie_mccolm)");
  if (!key) return;
  if (*key == "fixed_db_m") {
    FixedAbsorptionSpec fixed;
    read_number(faults, *absorption, "fixed_db_m", from_to(0, 1000), fixed.db_m);
    for (const char* other : {"temperature_c", "salinity_psu", "ph", "depth_m"}) {
      const auto useless = child(*absorption, other);
      if (!useless) continue;
      add_fault(faults, useless->place, useless->path,
                "of no effect beside fixed_db_m, accepted is either alone");
    }
    water.absorption = fixed;
    return;
  }
  SeaAbsorptionSpec model;
  read_choice<AbsorptionModel>(faults, *absorption, "model",
                               {{"francois_garrison", AbsorptionModel::francois_garrison},
                                {"ainslie_mccolm", AbsorptionModel::ainslie_mccolm}},
                               model.model, Need::required);
  read_number(faults, *absorption, "temperature_c", from_to(-5, 60), model.temperature_c);
  read_number(faults, *absorption, "salinity_psu", from_to(0, 100), model.salinity_psu);
  read_number(faults, *absorption, "ph", from_to(5, 10), model.ph);
  read_number(faults, *absorption, "depth_m", from_to(0, 12000), model.depth_m);
  water.absorption = model;
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
