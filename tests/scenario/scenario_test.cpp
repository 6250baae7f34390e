#include <cmath>

#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::kExample;
using testing::kHead;
using testing::parse;
using testing::read_again;

// Protects the example that every reader of the documentation starts from.
TEST_CASE("the documentation's example is read as it says") {
  const auto scenario = value_of(parse(kExample));
  CHECK(scenario.name == "tank_example");
  CHECK(scenario.seed == 7);
  CHECK(scenario.sonar.range_max_m == 10);
  CHECK(scenario.sonar.frequency_hz == 900e3);
  CHECK(std::get<SeaAbsorptionSpec>(scenario.water.absorption).depth_m == 5);
  REQUIRE(scenario.materials.size() == 2);
  CHECK(scenario.materials[0].name == "concrete");
  CHECK(scenario.materials[0].reflectivity == 1e-3);
  CHECK(std::get<RicianSpec>(scenario.materials[1].coherent).k == 0.5);
  REQUIRE(scenario.objects.size() == 2);
  const auto& box = std::get<BoxSpec>(scenario.objects[0].shape);
  CHECK(box.inside);
  CHECK(box.size_m == std::array<double, 3>{11, 11, 4});
  CHECK(scenario.objects[1].class_name == "cylinder");
  CHECK(scenario.objects[1].material == "steel");
  CHECK(scenario.objects[1].pose.position_m == std::array<double, 3>{4, 0, 0});
  REQUIRE(scenario.point_targets.size() == 1);
  CHECK(scenario.point_targets[0].target_strength_db == -40);
  CHECK(scenario.trajectory.ping_rate_hz == 5);
  CHECK(scenario.trajectory.pings == 10);
  CHECK(scenario.noise_spectrum_level_db == 30.0);
  CHECK(scenario.output.cartesian_height_px == 1000);
  CHECK_FALSE(scenario.output.selection.scatterers);
}

// Protects the defaults, which are part of every scenario that leaves something out.
TEST_CASE("what is left out has the documented default") {
  const auto scenario = value_of(parse(kHead));
  CHECK(scenario.seed == 0);
  CHECK(scenario.sequences == 1);
  CHECK(scenario.sonar.pulse.shape == PulseShape::gaussian);
  CHECK(scenario.sonar.window == Window::none);
  CHECK(scenario.sonar.shading.kind == Shading::uniform);
  CHECK_FALSE(scenario.sonar.transmit_width_deg);
  CHECK_FALSE(scenario.sonar.adc);
  CHECK(scenario.volumes.empty());
  CHECK(scenario.water.sound_speed_m_s == 1500);
  const auto& model = std::get<SeaAbsorptionSpec>(scenario.water.absorption);
  CHECK(std::array<double, 4>{model.temperature_c, model.salinity_psu, model.ph, model.depth_m} ==
        std::array<double, 4>{10, 35, 8, 0});
  CHECK(scenario.scattering.lambert_exponent == 1);
  CHECK(scenario.scattering.normalization == Normalization::calibrated);
  CHECK(scenario.scattering.speckle == SpeckleMode::per_ping);
  CHECK(scenario.objects.empty());
  const auto& poses = std::get<std::vector<TimedPoseSpec>>(scenario.trajectory.path);
  REQUIRE(poses.size() == 1);
  CHECK(poses[0].pose.position_m == std::array<double, 3>{0, 0, 0});
  CHECK(scenario.trajectory.ping_rate_hz == 1);
  CHECK(scenario.trajectory.pings == 1);
  CHECK_FALSE(scenario.noise_spectrum_level_db);
  CHECK_FALSE(scenario.noise_snr_db);
  CHECK(scenario.output.selection.timeseries);
  CHECK(scenario.output.selection.polar);
  CHECK(scenario.output.selection.cartesian);
  CHECK_FALSE(scenario.output.selection.cartesian_exr);
  CHECK(scenario.output.selection.png);
  CHECK_FALSE(scenario.output.selection.scatterers);
  CHECK_FALSE(scenario.output.png_db);
  CHECK(scenario.splits.train == 1);
  CHECK(scenario.splits.val == 0);
}

// Protects water that is described rather than numbered: read, written back and read the same.
TEST_CASE("sound speed and absorption may come from the water") {
  const auto scenario = value_of(
      parse(kHead +
            "water: {sound_speed_m_s: {from: {temperature_c: 4, salinity_psu: 35, depth_m: 50}}, "
            "absorption: {model: ainslie_mccolm, ph: 7.9}}\n"));
  REQUIRE(scenario.water.sound_speed_from);
  CHECK(scenario.water.sound_speed_from->depth_m == 50);
  const auto& model = std::get<SeaAbsorptionSpec>(scenario.water.absorption);
  CHECK(model.model == AbsorptionModel::ainslie_mccolm);
  CHECK(model.ph == 7.9);
  read_again(scenario);
}

// Protects short scenarios: the file's name will do, as long as it can be printed.
TEST_CASE("a scenario without a name is called after its file") {
  const std::string text = "ensonify: 1\nsonar: {preset: blueview_p900_90}\n";
  CHECK(parse_scenario(text, "some/where/my tank.yaml", ".")->name == "my tank");
  CHECK(parse_scenario(text, "a\nb.yaml", ".")->name == "scenario");
}

// Protects seeds as identities: not one bit may be lost on the way through a double.
TEST_CASE("a seed is read to the last digit") {
  for (const char* seed : {"0", "9007199254740993", "18446744073709551615"}) {
    const auto scenario = value_of(parse(kHead + "seed: " + seed + "\n"));
    CHECK(std::to_string(scenario.seed) == seed);
  }
}

// Protects the forms that the contract allows for outputs: off, on, or with options.
TEST_CASE("outputs are off, on or with options") {
  const auto scenario = value_of(
      parse(kHead + "output: {timeseries: none, polar: off, cartesian: on, png: {db: [-20, 40]}, "
                    "scatterers: true}\n"));
  CHECK_FALSE(scenario.output.selection.timeseries);
  CHECK_FALSE(scenario.output.selection.polar);
  CHECK(scenario.output.selection.cartesian);
  CHECK(scenario.output.selection.png);
  CHECK(scenario.output.png_db == std::array<double, 2>{-20, 40});
  CHECK(scenario.output.selection.scatterers);
  const auto with_exr = value_of(parse(kHead + "output: {cartesian: {exr: true}}\n"));
  CHECK(with_exr.output.selection.cartesian);
  CHECK(with_exr.output.selection.cartesian_exr);
  CHECK(with_exr.output.cartesian_height_px == 1000);
}

// Protects the defaults of labels that go with pictures.
TEST_CASE("shadows and amodal masks are on where there are polar or Cartesian pictures") {
  const auto selection = [](const std::string& output) {
    const auto scenario = value_of(parse(kHead + output));
    return scenario.output.selection;
  };
  CHECK(selection("").shadow);
  CHECK(selection("").amodal);
  CHECK(selection("output: {polar: false}\n").shadow);
  CHECK_FALSE(selection("output: {polar: false, cartesian: false}\n").shadow);
  CHECK_FALSE(selection("output: {polar: false, cartesian: false}\n").amodal);
  CHECK(selection("output: {polar: false, cartesian: false, amodal: true}\n").amodal);
  CHECK_FALSE(selection("output: {shadow: false}\n").shadow);
  CHECK(selection("output: {shadow: false}\n").amodal);
  CHECK_FALSE(selection("output: {amodal: off}\n").amodal);
}

// Protects the picture's settings, and that written back they say the same.
TEST_CASE("grey pictures have a scale, limits, a gain and one that grows with range") {
  Display nearest;
  nearest.resampling = Resampling::nearest;
  const std::pair<const char*, Display> cases[] = {
      {"{resampling: nearest}", nearest},
      {"{resampling: bilinear}", {}},
      {"{scale: amplitude}", {GreyScale::amplitude}},
      {"{scale: amplitude, gamma: 0.5}", {GreyScale::amplitude, 0.5}},
      {"{gain_db: -3.5}", {GreyScale::db, 1, -3.5}},
      {"{automatic_gain: true}", {GreyScale::db, 1, 0, 0, false, true}},
      {"{tvg: true}", {GreyScale::db, 1, 0, 40, true}},
      {"{tvg: {}}", {GreyScale::db, 1, 0, 40, true}},
      {"{tvg: false, scale: db}", {}},
      {"{db: [1, 2], tvg: {spreading: 20, absorption: false}}", {GreyScale::db, 1, 0, 20}}};
  for (const auto& [text, settings] : cases) {
    INFO(text);
    const auto scenario = value_of(parse(kHead + "output: {png: " + text + "}\n"));
    CHECK(scenario.output.selection.png);
    CHECK(scenario.output.png == settings);
    const Scenario again = read_again(scenario);
    CHECK(again.output.png == settings);
    CHECK(again.output.png_db == scenario.output.png_db);
  }
}

// Protects a user from a gamma that nothing would show.
TEST_CASE("a gamma needs a gray level that is a power of the amplitude") {
  check_fails(parse(kHead + "output: {png: {gamma: 0.5}}\n"),
              {"expected only with scale amplitude"});
}

// Protects the words that choose targets: names, classes, names with a count, also those that a
// sequence happens not to draw.
TEST_CASE("layers name their targets") {
  const std::string world =
      kHead +
      "materials: {m: {reflectivity: 1}}\n"
      "objects: [{name: ball, class: mine, count: {choice: [0, 2]}, material: m, "
      "shape: {sphere: {radius_m: 1}}}]\n"
      "point_targets: [{name: tip, target_strength_db: -40, position_m: [1, 0, 0]}]\n"
      "volumes: [{name: water, uniform: {strength_db: -60}}]\n";
  for (const char* word : {"ball", "ball_1", "mine", "tip", "point_target"}) {
    const std::string text = world + "output: {layers: {targets: [" + word + "]}}\n";
    const auto scenario = value_of(parse(text));
    CHECK(scenario.output.selection.layers);
    CHECK(scenario.output.layer_targets == std::vector<std::string>{word});
    const Scenario again = read_again(scenario);
    CHECK(again.output.layer_targets == scenario.output.layer_targets);
  }
  check_fails(
      parse(world + "output: {layers: {targets: [bal, water]}}\n"),
      {"output.layers.targets.0", "did you mean ball?", "volumes have a layer of their own"});
  CHECK_FALSE(parse(world)->output.selection.layers);
  CHECK_FALSE(parse(world + "output: {layers: true}\n")->output.layer_targets);
}

// Protects whoever asks for pictures that an array cannot be.
TEST_CASE("pings are packed by sequence only as arrays") {
  CHECK_FALSE(parse(kHead)->output.selection.packed);
  CHECK(parse(kHead + "output: {one_file_per: sequence}\n")->output.selection.packed);
  CHECK_FALSE(
      parse(kHead + "output: {one_file_per: ping, timeseries: exr}\n")->output.selection.packed);
  for (const char* format : {"exr", "both"}) {
    check_fails(parse(kHead + "output: {one_file_per: sequence, timeseries: " + format + "}\n"),
                {"output.one_file_per"});
  }
}

TEST_CASE("the series comes as NPY, as EXR, as both or not at all") {
  const std::pair<const char*, std::pair<bool, bool>> words[] = {{"npy", {true, false}},
                                                                 {"exr", {false, true}},
                                                                 {"both", {true, true}},
                                                                 {"none", {false, false}}};
  for (const auto& [word, formats] : words) {
    const auto scenario = value_of(parse(kHead + "output: {timeseries: " + word + "}\n"));
    CHECK(scenario.output.selection.timeseries == formats.first);
    CHECK(scenario.output.selection.timeseries_exr == formats.second);
    const Scenario again = read_again(scenario);
    CHECK(again.output.selection.timeseries == formats.first);
    CHECK(again.output.selection.timeseries_exr == formats.second);
  }
}

// Protects the reading of legitimate numbers of unusual look, and anchors in a scenario.
TEST_CASE("unusual but legitimate forms are read") {
  const auto scenario = value_of(
      parse(kHead +
            "water: {sound_speed_m_s: +1.5e3}\nscattering: {lambert_exponent: 0e3}\n"
            "materials: {\"010\": &steel {reflectivity: .5}, b: *steel}\n"
            "objects: [{name: \"yes\", material: \"010\", shape: {plane: {}}}]\n"
            "trajectory: {poses: [{position_m: [-0, 5., -.5]}]}\nsplits: {val: 3, test: 1}\n"));
  CHECK(scenario.water.sound_speed_m_s == 1500);
  CHECK(scenario.scattering.lambert_exponent == 0);
  CHECK(scenario.materials[1].reflectivity == 0.5);
  const auto& poses = std::get<std::vector<TimedPoseSpec>>(scenario.trajectory.path);
  CHECK_FALSE(std::signbit(poses[0].pose.position_m[0]));
  CHECK(poses[0].pose.position_m[2] == -0.5);
  CHECK(scenario.splits.train == 0);
  CHECK(scenario.splits.val == 3);
}

// Protects the meaning of a missing `pings`: one for a sonar at rest, else the path's own length.
TEST_CASE("pings left out follow the path") {
  const auto rest = parse(kHead + "trajectory: {poses: [{time_s: 3}]}\n");
  const auto path = parse(kHead + "trajectory: {poses: [{time_s: 0}, {time_s: 3}]}\n");
  REQUIRE(rest.ok());
  REQUIRE(path.ok());
  CHECK(rest->trajectory.pings == 1);
  CHECK_FALSE(path->trajectory.pings);
}

}  // namespace
}  // namespace ensonify
