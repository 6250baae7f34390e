#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::joined_lines;
using testing::parse;
using testing::tells;

std::string using_preset(const std::string& sonar) {
  return "ensonify: 1\nname: t\nsonar: {" + sonar + "}\n";
}

// Protects the presets that travel in the program: all there, whole, sorted, each with its source,
// and the resolved text needs no preset any more.
TEST_CASE("every preset is a whole sonar") {
  const std::vector<std::string> expected = {
      "aris_3000_hf",     "aris_3000_lf",     "blueview_m450_90", "blueview_p900_90",
      "gemini_1200ik_hf", "gemini_1200ik_lf", "oculus_m1200d_hf", "oculus_m1200d_lf",
      "oculus_m750d_hf",  "oculus_m750d_lf",  "paper_table1",     "seabat_f50"};
  std::vector<std::string> names;
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    names.push_back(preset.name);
    CHECK(preset.description.find("Assumed") != std::string::npos);
    CHECK(preset.description.find('#') == std::string::npos);
    CHECK(preset.yaml.find("frequency_hz: ") != std::string::npos);
    const auto scenario = parse(using_preset("preset: " + preset.name));
    INFO((scenario.ok() ? "" : scenario.error().message));
    REQUIRE(scenario.ok());
    const std::string text = emit(*scenario);
    CHECK(text.find("preset") == std::string::npos);
    const auto again = parse(text);
    REQUIRE(again.ok());
    CHECK(emit(*again) == text);
  }
  CHECK(names == expected);
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
    CHECK(sonar.elevation_fan_deg == 20);
    CHECK(sonar.rays_elevation == 114);
    CHECK(sonar.rays_azimuth == 1);
    CHECK(sonar.range_max_m == 60);
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
  const struct {
    std::string sonar, begin, essential;
  } cases[] = {
      {"preset: seabat_f51",
       "3:17: sonar.preset:", "(did you mean seabat_f50?), accepted is one of aris"},
      {"preset: zzz",
       "3:17: sonar.preset:", "`zzz` is not known, accepted is one of aris_3000_hf, "},
      {"preset: [a]", "3:17: sonar.preset:", "a list stands here"},
      {"preset: seabat_f50, pulse: flatt", "3:36: sonar.pulse:", "did you mean flat?"},
      {"preset: seabat_f50, beams: {spacing_deg: 1, fov_deg: 9}", "3:53: sonar.beams:", "exclude"},
      {"preset: seabat_f50, beams: {spacing_deg: 1}", "3:50: sonar.beams.spacing_deg:", "span 256"},
      {"preset: seabat_f50, beams: {fov_deg: 181}", "3:46: sonar.beams.fov_deg:", "at most 180"},
      {"preset: seabat_f50, beams: {count: 0}", "3:44: sonar.beams.count:", "from 1 to 65536"},
      {"preset: seabat_f50, beams: 3", "3:36: sonar.beams:", "accepted is a map with count"},
      {"preset: seabat_f50, elevation: {fan_deg: 200}", "3:50: sonar.elevation.fan_deg:", "180"},
      {"preset: seabat_f50, rays: {elevation: 0}", "3:47: sonar.rays.elevation:", "from 1 to"},
      {"preset: seabat_f50, range_min_m: 120", "3:42: sonar.range_min_m:", "is not below"},
      {"preset: seabat_f50, range_max_m: 0.2", "3:42: sonar.range_max_m:", "is not below"},
      {"preset: seabat_f50, range_min_m: -1", "3:42: sonar.range_min_m:", "from 0 to"},
      {"preset: seabat_f50, bandwidth_hz: 800e3", "3:43: sonar.bandwidth_hz:", "below zero"},
      {"preset: seabat_f50, frequency_hz: 10e3", "3:43: sonar.frequency_hz:", "below zero"},
      {"preset: seabat_f50, window: han", "3:37: sonar.window:", "did you mean hann?"},
      {"preset: seabat_f50, mount: {position_m: [0, 0]}",
       "3:49: sonar.mount.position_m:", "3 numbers"},
      {"preset: seabat_f50, range_max_m: 1e6", "3:8: sonar:", "more than 2^28"},
      {"preset: seabat_f50, rays: {elevation: 300000}", "3:8: sonar:", "more than 2^27"},
  };
  for (const auto& c : cases) {
    const auto lines = faults_of(using_preset(c.sonar));
    INFO(c.sonar << "\n" << joined_lines(lines));
    CHECK(lines.size() == 1);
    CHECK(tells(lines, "t.yaml:" + c.begin, c.essential));
  }
}

}  // namespace
}  // namespace ensonify
