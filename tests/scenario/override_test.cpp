#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::faults_of;
using testing::kExample;
using testing::kHead;
using testing::parse;
using testing::tells;

// Protects `--set`: any key, list items by index, missing maps made, the last one wins.
TEST_CASE("overrides replace, add and append") {
  const auto scenario = value_of(parse(
      kExample, {{"seed", "8"},
                 {"seed", "9"},
                 {"objects.0.name", "\"010\""},
                 {"point_targets.1", "{name: p, target_strength_db: -30, position_m: [1, 2, 3]}"},
                 {"splits.val", "0.5"},
                 {"objects.1.shape.cylinder.radius_m", "0.3"},
                 {"output.png", "{db: [-10, 60]}"},
                 {"sonar.mount.position_m", "[0, 0, -1]"},
                 {"materials.sphere.reflectivity", "1e-4"},
                 {"materials.box.reflectivity", "2e-4"}}));
  CHECK(scenario.seed == 9);
  CHECK(scenario.objects[0].name == "010");
  REQUIRE(scenario.point_targets.size() == 2);
  CHECK(scenario.point_targets[1].position_m[2] == 3);
  CHECK(scenario.splits.val == 0.5);
  CHECK(std::get<CylinderSpec>(scenario.objects[1].shape).radius_m == 0.3);
  CHECK(std::get<CylinderSpec>(scenario.objects[1].shape).height_m == 2);
  CHECK(scenario.output.png_db == std::array<double, 2>{-10, 60});
  CHECK(scenario.sonar.mount.position_m[2] == -1);
  // Names of materials are the user's own, though shapes of these names exclude each other.
  REQUIRE(scenario.materials.size() == 4);
}

// Protects sweeps and command lines from lists whose order changes.
TEST_CASE("overrides name items of lists by their names too") {
  const auto scenario =
      value_of(parse(kExample, {{"objects.1.name", "post"},
                                {"objects.post.shape.cylinder.radius_m", "0.4"},
                                {"point_targets.calibration.target_strength_db", "-31"}}));
  CHECK(std::get<CylinderSpec>(scenario.objects[1].shape).radius_m == 0.4);
  REQUIRE(scenario.point_targets.size() == 1);
  CHECK(scenario.point_targets[0].target_strength_db == -31);
}

// Protects the convenience that an override need not remove what it excludes.
TEST_CASE("an override takes the place of what excludes it") {
  const auto scenario =
      value_of(parse(kExample, {{"sonar.beams.spacing_deg", "0.1"},
                                {"water.absorption.fixed_db_m", "0.25"},
                                {"objects.0.shape.sphere.radius_m", "6"},
                                {"objects.1.pose.quaternion_wxyz", "[1, 0, 0, 1]"}}));
  CHECK(scenario.sonar.beam_fov_deg == Approx(51.2));
  CHECK(std::get<FixedAbsorptionSpec>(scenario.water.absorption).db_m == 0.25);
  CHECK(std::get<SphereSpec>(scenario.objects[0].shape).radius_m == 6);
  CHECK(std::get<Quat>(scenario.objects[1].pose.rotation).z == 1);
  const auto back = value_of(parse(kHead + "water: {absorption: {fixed_db_m: 1}}\n",
                                   {{"water.absorption.model", "francois_garrison"}}));
  CHECK(std::holds_alternative<SeaAbsorptionSpec>(back.water.absorption));
}

// Protects the messages of `--set`, whose place is the option itself, and its strictness.
TEST_CASE("faults of an override name the option") {
  const struct {
    std::string path, value, essential;
  } cases[] = {
      {"seed", "010", "seed: `010` looks like an octal number"},
      {"name", "", "name: found nothing"},
      {"name", "yes", "name: `yes` is a boolean"},
      {"name", "\"x", "name: not valid YAML"},
      {"name", "\"x\n", "name: not valid YAML: the quote"},
      {"noise", "{spectrum_level_db: 1, spectrum_level_db: 2}",
       "noise.spectrum_level_db: the key is given twice"},
      {"name", "a\n---\nb", "name: a second document"},
      {"name", std::string("a\0b", 3), "name: a NUL byte"},
      {"name", "[[", "name: not valid YAML"},
      {"name", std::string(100000, '['), "name: the text is nested more than 64 levels deep"},
      {"name", "&a [*a]", "name: this alias refers to"},
      {"sonar.preset", "blueview_p900",
       "sonar.preset: `blueview_p900` is not known (did you mean "},
      {"sonar.range_mx_m", "5", "sonar.range_mx_m: unknown key (did you mean range_max_m?)"},
      {"objects.3.name", "x", "objects.3.name: `3` names no item of this list of length 2"},
      {"objects.-1.name", "x", "objects.-1.name: `-1` names no item"},
      {"objects.00.name", "x", "objects.00.name: `00` names no item"},
      {"objects.first.name", "x", "objects.first.name: `first` names no item"},
      {"objects.targt.name", "x",
       "objects.targt.name: `targt` names no item of this list of length 2 (did you mean target?); "
       "expected an index from 0 to 2 or one of tank, target"},
      {"seed.a", "1", "seed.a: `7` is a plain value"},
      {"a..b", "1", "a..b: the path has an empty key"},
      {"", "1", "the path has an empty key"},
      {"seed.", "1", "seed.: the path has an empty key"},
  };
  for (const auto& c : cases) {
    const auto lines = faults_of(kExample, {{c.path, c.value}});
    INFO(c.path << "=" << c.value.substr(0, 50) << "\n" << joined_lines(lines));
    CHECK(lines.size() == 1);
    CHECK(tells(lines, "--set " + c.path + ": ", c.essential));
  }
}

// Protects "several faults at once" across file and command line.
TEST_CASE("faults of the file and of overrides come together") {
  const auto lines = faults_of(kHead + "wter: {}\n", {{"seed", "x"}, {"name", "7"}});
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].starts_with("t.yaml:4:1: wter: "));
  CHECK(lines[1].starts_with("--set seed: seed: "));
  CHECK(lines[2].starts_with("--set name: name: "));
}

}  // namespace
}  // namespace ensonify
