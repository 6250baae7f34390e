#include <algorithm>
#include <set>

#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::kHead;

const std::string kDrawn = R"(ensonify: 1
name: drawn
seed: 5
sequences: 51
sonar:
  preset: blueview_p900_90
  range_max_m: {uniform: [10.5, 20]}
  window: {choice: [hann, none]}
  beams: {choice: [{count: 64}, {count: {uniform: [100, 128]}, spacing_deg: 0.5}]}
water: {sound_speed_m_s: {normal: [1490, 3]}, absorption: {choice: [{fixed_db_m: 0.1}, {model: ainslie_mccolm, ph: {uniform: [7.5, 8.0]}}]}}
materials:
  sand: {reflectivity: {log_uniform: [1.0e-4, 1e-2]}}
  "010": {reflectivity: 1, law: {choice: [lambert, lommel_seeliger]}}
objects:
  - {name: "the: floor", class: floor, material: sand, shape: {plane: {}}}
  - name: rock
    count: {uniform: [0, 4]}
    material: {choice: [sand, "010"]}
    shape: {choice: [{sphere: {radius_m: {uniform: [{uniform: [0.1, 0.2]}, 0.5]}}}, {box: {size_m: [1, 1, {choice: [0.5, 1]}]}}]}
    place: {on: "the: floor", area_m: [[0, -5], [10, 5]], align: surface, rotation_deg: [{uniform: [0, 360.5]}, 0, 0]}
point_targets:
  - {name: t, count: 2, target_strength_db: {uniform: [-40.0, -20]}, position_m: {choice: [[1, 0, 0], [2, 0, {uniform: [0, 1.0]}]]}}
trajectory:
  poses: [{position_m: [0, {uniform: [-1, 1.0]}, 2]}]
  pings: {choice: [1, 2]}
noise: {choice: [{snr_db: 20}, {spectrum_level_db: {uniform: [20, 40]}}]}
output: {cartesian: {choice: [off, {height_px: 99}]}, scatterers: true}
)";

// The drawn values alone, as a scenario without distributions.
std::string flat(Scenario scenario) {
  scenario.drawn_sections = nullptr;
  return emit(scenario);
}

// Protects a data set's own scenario.yaml: it draws the same in every sequence, and reads back to
// itself; and it is one text for all sequences, which the identity of the work hangs on.
TEST_CASE("the resolved text draws the same again") {
  const auto first = value_of(parse_scenario(kDrawn, "t.yaml", "."));
  const std::string text = emit(first);
  INFO(text);
  std::vector<std::string> worlds;
  for (std::uint32_t sequence = 0; sequence <= 50; ++sequence) {
    const auto given = parse_scenario(kDrawn, "t.yaml", ".", {}, sequence);
    const auto again = parse_scenario(text, "again.yaml", ".", {}, sequence);
    INFO(sequence);
    require_ok(given);
    require_ok(again);
    CHECK(emit(*given) == text);
    CHECK(emit(*again) == text);
    CHECK(flat(*again) == flat(*given));
    CHECK(again->draws == given->draws);
    worlds.push_back(flat(*given));
  }
  std::sort(worlds.begin(), worlds.end());
  CHECK(std::adjacent_find(worlds.begin(), worlds.end()) == worlds.end());
}

// Protects the record of one sequence: the drawn values, written as a scenario, are that sequence.
TEST_CASE("a drawn sequence written flat reads back to itself") {
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    const auto scenario = value_of(parse_scenario(kDrawn, "t.yaml", ".", {}, sequence));
    const std::string text = flat(scenario);
    INFO(text);
    const auto again = value_of(parse_scenario(text, "t.yaml", "."));
    CHECK(emit(again) == text);
    CHECK(again.draws.empty());
  }
}

// Protects the resolved text as such: presets stand in it with their values.
TEST_CASE("a drawn sonar is written with its preset's keys") {
  const auto scenario = value_of(testing::parse(
      "ensonify: 1\nsonar: {preset: blueview_p900_90, range_max_m: {uniform: [10.5, 20]}}\n"));
  const std::string text = emit(scenario);
  CHECK_FALSE(contains(text, "preset"));
  CHECK(contains(text, "frequency_hz: 900"));
  CHECK(contains(text, "range_max_m: {uniform: [10.5, 20]}"));
}

// Protects what a range that is sampled means for a preset with rows: each sequence has the
// bandwidth of its own range, also where the resolved text is read again.
TEST_CASE("a sampled range selects the preset's bandwidth in each sequence") {
  const std::string text =
      "ensonify: 1\nsonar: {preset: oculus_m1200d_hf, range_max_m: {choice: [2, 4, 8]}}\n";
  std::set<double> found;
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const auto scenario = value_of(parse_scenario(text, "t.yaml", ".", {}, sequence));
    const SonarSpec& sonar = scenario.sonar;
    const double expected = sonar.range_max_m == 2 ? 262e3 : sonar.range_max_m == 4 ? 131e3 : 65600;
    CHECK(sonar.bandwidth_hz == expected);
    found.insert(sonar.bandwidth_hz);
    const auto again = value_of(parse_scenario(emit(scenario), "t.yaml", ".", {}, sequence));
    CHECK(again.sonar.range_max_m == sonar.range_max_m);
    CHECK(again.sonar.bandwidth_hz == sonar.bandwidth_hz);
  }
  CHECK(found.size() == 3);
}

// Protects assets: every file that some sequence needs is listed, hashed and renamed, in the same
// order whatever is drawn; one that is missing is told in every sequence.
TEST_CASE("files of every alternative are input files") {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.obj", "b.obj", "c.obj"}) folder.write(name, "v 0 0 0\n");
  const std::string head =
      kHead + "materials: {m: {reflectivity: 1}}\nobjects:\n  - {name: o, material: m, shape: ";
  const std::string text =
      head +
      "{choice: [{mesh: {file: {choice: [b.obj, a.obj]}}}, {mesh: {file: c.obj}}, {plane: {}}]}}\n";
  const auto names_by_hash = [](const std::filesystem::path& file) {
    return "assets/12-" + file.filename().string();
  };
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    const auto scenario = value_of(parse_scenario(text, "t.yaml", folder.path(), {}, sequence));
    CHECK(input_files(scenario) == std::vector<std::filesystem::path>{folder.path() / "b.obj",
                                                                      folder.path() / "a.obj",
                                                                      folder.path() / "c.obj"});
    CHECK(contains(to_yaml(scenario, names_by_hash),
                   "{choice: [{mesh: {file: {choice: [\"assets/12-b.obj\", "
                   "\"assets/12-a.obj\"]}}}, {mesh: {file: \"assets/12-c.obj\"}}, {plane: {}}]}"));
    check_fails(parse_scenario(head + "{choice: [{plane: {}}, {mesh: {file: d.obj}}]}}\n", "t.yaml",
                               folder.path(), {}, sequence),
                {"`d.obj` does not exist"});
  }
}

// Protects odd texts on their way through the kept tree.
TEST_CASE("text in a drawn section is written so that it reads the same") {
  const std::string name = "\"a, b: [c] \\\"d\\\" \\\\ # \xC3\xA4 \xF0\x9F\x90\x9F\"";
  const auto scenario = value_of(testing::parse(
      kHead + "point_targets:\n  - name: x y, z\n    target_strength_db: {uniform: [1.5, 2]}\n" +
      "    position_m: [0, 0, 0]\n  - {name: " + name +
      ", class: \"12\", target_strength_db: 1, position_m: [0, 0, 0]}\n"));
  INFO(emit(scenario));
  const auto again = value_of(testing::parse(emit(scenario)));
  CHECK(flat(again) == flat(scenario));
  CHECK(again.point_targets[0].name == "x y, z");
}

}  // namespace
}  // namespace ensonify
