#include <algorithm>
#include <cstdio>
#include <sstream>

#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::parse;
using testing::tells;

std::string using_preset(const std::string& sonar) {
  return "ensonify: 1\nname: t\nsonar: {" + sonar + "}\n";
}

// Protects the presets that travel in the program: all there, whole, sorted, each with its source,
// and the resolved text needs no preset any more.
TEST_CASE("every preset is a whole sonar") {
  std::vector<std::string> names;
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    names.push_back(preset.name);
    CHECK(contains(preset.description, "Assumed"));
    CHECK_FALSE(contains(preset.description, "#"));
    CHECK(contains(preset.yaml, "frequency_hz: "));
    const auto scenario = value_of(parse(using_preset("preset: " + preset.name)));
    const std::string text = emit(scenario);
    CHECK_FALSE(contains(text, "preset"));
    const auto again = value_of(parse(text));
    CHECK(emit(again) == text);
  }
  CHECK(names.size() >= 20);
  CHECK(std::is_sorted(names.begin(), names.end()));
}

double bandwidth_of(const std::string& sonar) {
  INFO(sonar);
  const auto scenario = value_of(parse(using_preset(sonar)));
  return scenario.sonar.bandwidth_hz;
}

// Protects the range bins of the public pings of the M1200d at 2.1 MHz: 2.835 mm at 1 m (352 bins,
// sound speed 1487.03 m/s), 2.842 mm at 2 m (703 bins, 1490.66 m/s), 5.673 mm at 3 m (528 bins,
// 1487.61 m/s).
TEST_CASE("range bins of the Oculus M1200d are those of public pings") {
  const struct {
    double range_m, bin_m, speed_m_s;
  } pings[] = {{1, 0.002835, 1487.03}, {2, 0.00284219, 1490.66}, {3, 0.00567274, 1487.61}};
  for (const auto& ping : pings) {
    const double b =
        bandwidth_of("preset: oculus_m1200d_hf, range_max_m: " + std::to_string(ping.range_m));
    CHECK(ping.speed_m_s / (2 * b) == Approx(ping.bin_m).epsilon(2e-3));
  }
}

// Protects the choice of a row: its limit belongs to it, the last one holds beyond all limits, the
// preset's own range and the scenario's bandwidth count where they stand, and `--set` as the file.
TEST_CASE("a preset's bandwidth is chosen by the scenario's range") {
  CHECK(bandwidth_of("preset: oculus_m1200d_hf, range_max_m: 2.5") == 262000);
  CHECK(bandwidth_of("preset: oculus_m1200d_hf, range_max_m: +2.5") == 262000);
  CHECK(bandwidth_of("preset: oculus_m1200d_hf, range_max_m: 2.6") == 131000);
  CHECK(bandwidth_of("preset: oculus_m1200d_hf, range_max_m: 25") == 65600);
  CHECK(bandwidth_of("preset: oculus_m1200d_hf") == 65600);
  CHECK(bandwidth_of("preset: oculus_m1200d_hf, range_max_m: 2, bandwidth_hz: 5e4") == 5e4);
  CHECK(bandwidth_of("preset: seabat_f50, range_max_m: 2") == 29900);
  const auto set = value_of(parse_scenario(using_preset("preset: oculus_m1200d_hf"), "t.yaml", ".",
                                           {{"sonar.range_max_m", "4"}}));
  CHECK(set.sonar.bandwidth_hz == 131000);
  const auto wrong = faults_of(using_preset("preset: oculus_m1200d_hf, range_max_m: far"));
  INFO(joined_lines(wrong));
  CHECK(wrong.size() == 1);
  CHECK(tells(wrong, "t.yaml:3:", "sonar.range_max_m"));
}

// Protects pings from growing without need: 2,000 samples at most at any range that a row covers,
// and finer bins at shorter ranges. The range at the end of a row has the most samples.
TEST_CASE("rows of presets rise in range and keep pings small") {
  int with_rows = 0;
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    std::istringstream lines(preset.yaml);
    double range_m = 0, bandwidth_hz = 1e9, up_to_m = 0, row_hz = 0;
    for (std::string line; std::getline(lines, line);) {
      if (std::sscanf(line.c_str(), "  - {up_to_m: %lf, bandwidth_hz: %lf}", &up_to_m, &row_hz) !=
          2) {
        continue;
      }
      CHECK(up_to_m > range_m);
      CHECK(row_hz < bandwidth_hz);
      CHECK(2 * up_to_m * row_hz / 1500 <= 2000);
      range_m = up_to_m;
      bandwidth_hz = row_hz;
      CHECK(bandwidth_of("preset: " + preset.name + ", range_max_m: " + std::to_string(up_to_m)) ==
            row_hz);
    }
    if (range_m == 0) continue;
    ++with_rows;
    const auto scenario = value_of(parse(using_preset("preset: " + preset.name)));
    CHECK(range_m == scenario.sonar.range_max_m);
    CHECK(bandwidth_hz == scenario.sonar.bandwidth_hz);
  }
  CHECK(with_rows >= 9);
}

// Protects the Surveyor's line, by the beam width that a uniform line of its length has.
TEST_CASE("the Surveyor has its array of 16 elements") {
  const auto scenario = value_of(parse(using_preset("preset: surveyor_240_16")));
  const SonarSpec& sonar = scenario.sonar;
  REQUIRE(sonar.array);
  CHECK(sonar.array->elements == 16);
  const double length_m = 16 * sonar.array->spacing_m.value();
  const double width_rad = 0.886 * (1500 / sonar.frequency_hz) / length_m;
  CHECK(sonar.beam_width_deg == Approx(width_rad * 180 / kPi).epsilon(0.01));
}

// Protects the numbers that the reference scenes rest on.
TEST_CASE("the paper's sonar has the paper's numbers") {
  const auto released = parse(using_preset("preset: blueview_p900_90"));
  const auto printed = parse(using_preset("preset: paper_table1"));
  REQUIRE(released.ok());
  REQUIRE(printed.ok());
  CHECK(released->sonar.bandwidth_hz == 29900);
  CHECK(printed->sonar.bandwidth_hz == 2950);
  for (const SonarSpec& sonar : {released->sonar, printed->sonar}) {
    CHECK(sonar.frequency_hz == 900e3);
    CHECK(sonar.source_level_db == 220);
    CHECK(sonar.beam_count == 512);
    CHECK(sonar.beam_fov_deg == 90);
    CHECK(sonar.beam_width_deg == 1);
    CHECK(sonar.elevation_width_deg == 20);
    CHECK(sonar.rays_azimuth == 1);
    CHECK(sonar.range_max_m == 60);
  }
  CHECK(printed->sonar.elevation_shading.kind == Shading::uniform);
  CHECK(printed->sonar.elevation_fan_deg == 20);
  CHECK(printed->sonar.rays_elevation == 114);
  CHECK(printed->sonar.rays_per_cell == 0);
}

// Protects the density of rays: that of the paper, over the whole fan of each preset.
TEST_CASE("presets have a ray for each 0.18 degrees of elevation") {
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    const auto scenario = value_of(parse(using_preset("preset: " + preset.name)));
    const SonarSpec& sonar = scenario.sonar;
    CHECK(sonar.elevation_fan_deg / sonar.rays_elevation == Approx(20.0 / 114).epsilon(0.015));
    CHECK(sonar.rays_per_cell.has_value() == (preset.name == "paper_table1"));
  }
}

// Protects the deep merge: what stands beside a preset changes that and nothing else.
TEST_CASE("keys beside a preset replace the preset's") {
  const auto plain = parse(using_preset("preset: oculus_m750d_lf"));
  const auto changed = parse(using_preset(
      "preset: oculus_m750d_lf, range_max_m: 7, beams: {spacing_deg: 0.25}, rays: {azimuth: 3}, "
      "elevation: {fan_deg: 30}"));
  REQUIRE(plain.ok());
  REQUIRE(changed.ok());
  CHECK(changed->sonar.range_max_m == 7);
  CHECK(changed->sonar.beam_fov_deg == 128);
  CHECK(changed->sonar.rays_azimuth == 3);
  CHECK(changed->sonar.elevation_fan_deg == 30);
  CHECK(changed->sonar.elevation_width_deg == plain->sonar.elevation_width_deg);
  CHECK(changed->sonar.beam_count == plain->sonar.beam_count);
  CHECK(changed->sonar.beam_width_deg == plain->sonar.beam_width_deg);
  CHECK(changed->sonar.rays_elevation == plain->sonar.rays_elevation);
  CHECK(plain->sonar.beam_fov_deg == 130);
}

// Protects the help where a sonar is wrong: each missing key by name, presets by name.
TEST_CASE("faults of a sonar") {
  const auto missing = faults_of("ensonify: 1\nname: t\n");
  INFO(joined_lines(missing));
  for (const char* key :
       {"preset", "frequency_hz", "bandwidth_hz", "source_level_db", "range_max_m", "beams.count",
        "beams.fov_deg", "beams.receive_width_deg", "elevation.width_deg", "rays.elevation"}) {
    CHECK(tells(missing, std::string("t.yaml:1:1: sonar.") + key + ": ", "missing"));
  }
  CHECK(missing.size() == 10);
  testing::check_single_faults(
      {
          {"preset: seabat_f51",
           "3:17: sonar.preset:", "(did you mean seabat_f50?); expected one of aris"},
          {"preset: zzz",
           "3:17: sonar.preset:", "`zzz` is not known; expected one of aris_1200_48, "},
          {"preset: [a]", "3:17: sonar.preset:", "found a list"},
          {"preset: seabat_f50, pulse: flatt", "3:36: sonar.pulse:", "did you mean flat?"},
          {"preset: seabat_f50, beams: {spacing_deg: 1, fov_deg: 9}",
           "3:53: sonar.beams:", "exclude"},
          {"preset: seabat_f50, beams: {spacing_deg: 1}",
           "3:50: sonar.beams.spacing_deg:", "span 256"},
          {"preset: seabat_f50, beams: {fov_deg: 181}",
           "3:46: sonar.beams.fov_deg:", "at most 180"},
          {"preset: seabat_f50, beams: {count: 0}", "3:44: sonar.beams.count:", "from 1 to 65536"},
          {"preset: seabat_f50, beams: 3", "3:36: sonar.beams:", "expected a map with count"},
          {"preset: seabat_f50, elevation: {fan_deg: 200}",
           "3:50: sonar.elevation.fan_deg:", "180"},
          {"preset: seabat_f50, rays: {elevation: 0}", "3:47: sonar.rays.elevation:", "from 1 to"},
          {"preset: seabat_f50, range_min_m: 120", "3:42: sonar.range_min_m:", "is not below"},
          {"preset: seabat_f50, range_max_m: 0.2", "3:42: sonar.range_max_m:", "is not below"},
          {"preset: seabat_f50, range_min_m: -1", "3:42: sonar.range_min_m:", "from 0 to"},
          {"preset: seabat_f50, bandwidth_hz: 800e3", "3:43: sonar.bandwidth_hz:", "below zero"},
          {"preset: seabat_f50, frequency_hz: 10e3", "3:43: sonar.frequency_hz:", "below zero"},
          {"preset: seabat_f50, window: han", "3:37: sonar.window:", "did you mean hann?"},
          {"preset: seabat_f50, mount: {position_m: [0, 0]}",
           "3:49: sonar.mount.position_m:", "3 numbers"},
          {"preset: seabat_f50, range_max_m: 1e6", "3:8: sonar:", "exceed 2^28"},
          {"preset: seabat_f50, rays: {elevation: 300000}", "3:8: sonar:", "exceed 2^27"},
      },
      using_preset);
}

}  // namespace
}  // namespace ensonify
