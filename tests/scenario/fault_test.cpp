#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::faults_of;
using testing::kHead;
using testing::tells;

// Protects the contract's "nothing of a later version": keys that do not work yet are unknown.
TEST_CASE("keys of later versions are unknown") {
  check_single_faults({
      {"statistics: true", "4:1: statistics:", "unknown key; expected one of ensonify, name"},
      {"scattering: {speckle: bounces}",
       "4:23: scattering.speckle:", "one of per_ping, per_ray, surface"},
  });
}

// Protects the help for a mistyped key: the nearest one, or all of them.
TEST_CASE("an unknown key is met with the nearest known one") {
  check_single_faults({
      {"wter: {}", "4:1: wter:", "unknown key (did you mean water?)"},
      {"output: {timeserie: npy}", "4:10: output.timeserie:", "did you mean timeseries?"},
      {"trajectory: {poses: [{position: [0, 0, 0]}]}",
       "4:23: trajectory.poses.0.position:", "did you mean position_m?"},
      {"zzz: 1", "4:1: zzz:",
       "unknown key; expected one of ensonify, name, seed, speckle_seed, sequences, variables, "
       "sonar"},
      {"objects:\n  - {name: a, material: m, shape: {plane: {size: 1}}}\n"
       "materials: {m: {reflectivity: 1}}",
       "5:44: objects.0.shape.plane.size:", "this map has no keys"},
  });
}

// Protects the typed reading of numbers: place, path, and what is accepted.
TEST_CASE("wrong numbers are faults with the accepted range") {
  check_single_faults({
      {"seed: -1", "4:7: seed:", "from 0 to 18446744073709551615"},
      {"seed: 18446744073709551616", "4:7: seed:", "not an unsigned 64-bit integer"},
      {"seed: 1.0", "4:7: seed:", "not an unsigned 64-bit integer"},
      {"seed: \"7\"", "4:7: seed:", "the quoted text `7` is not a number"},
      {"seed: 010", "4:7: seed:", "`010` looks like an octal number"},
      {"seed: 0o17", "4:7: seed:", "`0o17` looks like an octal number"},
      {"sequences: 0", "4:12: sequences:", "an integer from 1 to 1000000"},
      {"sequences: 1000001", "4:12: sequences:", "an integer from 1 to 1000000"},
      {"sequences: 99999999999999999999", "4:12: sequences:", "out of range"},
      {"sequences: 1.5", "4:12: sequences:", "`1.5` is not an integer"},
      {"sequences: [1]", "4:12: sequences:", "a list is not a number"},
      {"water: {sound_speed_m_s: -010}",
       "4:26: water.sound_speed_m_s:", "`-010` looks like an octal number"},
      {"water: {sound_speed_m_s: .nan}", "4:26: water.sound_speed_m_s:", "not finite"},
      {"water: {sound_speed_m_s: inf}", "4:26: water.sound_speed_m_s:", "not finite"},
      {"water: {sound_speed_m_s: 1e999}", "4:26: water.sound_speed_m_s:", "too large or too small"},
      {"water: {sound_speed_m_s: 0x5DC}", "4:26: water.sound_speed_m_s:", "plain decimal"},
      {"water: {sound_speed_m_s: 1_500}", "4:26: water.sound_speed_m_s:", "plain decimal"},
      {"water: {sound_speed_m_s: fast}", "4:26: water.sound_speed_m_s:", "`fast` is not a number"},
      {"water: {sound_speed_m_s: }", "4:9: water.sound_speed_m_s:", "nothing is not a number"},
      {"water: {sound_speed_m_s: {from: {temperature_c: 4, salinity_psu: 35}}}",
       "4:33: water.sound_speed_m_s.from.depth_m:", "missing"},
      {"water: {sound_speed_m_s: {from: {temperature_c: 4, salinity_psu: 35, depth_m: 5}, b: 1}}",
       "4:83: water.sound_speed_m_s.b:", "unknown key"},
      {"water: {sound_speed_m_s: 20000}", "4:26: water.sound_speed_m_s:", "from 100 to 10000"},
      {"water: {sound_speed_m_s: 1500 1}", "4:26: water.sound_speed_m_s:", "is not a number"},
      {"scattering: {lambert_exponent: -1}", "4:32: scattering.lambert_exponent:", "from 0 to 100"},
      {"trajectory: {ping_rate_hz: 0}", "4:28: trajectory.ping_rate_hz:", "a number > 0"},
      {"trajectory: {pings: 0}", "4:21: trajectory.pings:", "from 1 to 1000000"},
      {"output: {cartesian: {height_px: 0}}", "4:33: output.cartesian.height_px:", "from 1 to"},
      {"output: {polar: false, cartesian: false, shadow: true}",
       "4:50: output.shadow:", "polar or cartesian"},
      {"output: {polar: off, cartesian: off, png: off, amodal: on}",
       "4:56: output.amodal:", "polar, cartesian or png"},
  });
}

// Protects what YAML readers disagree about or would silently convert.
TEST_CASE("wrong words, truth values, lists and maps are faults") {
  check_single_faults({
      {"scattering: {speckle: per_pings}", "4:23: scattering.speckle:", "did you mean per_ping?"},
      {"output: {timeseries: png}",
       "4:22: output.timeseries:", "expected one of npy, exr, both, none"},
      {"output: {timeseries: true}",
       "4:22: output.timeseries:", "expected one of npy, exr, both, none"},
      {"output: {polar: yes}", "4:17: output.polar:", "true (on), false (off)"},
      {"output: {polar: 1}", "4:17: output.polar:", "true (on), false (off)"},
      {"output: {polar: \"true\"}", "4:17: output.polar:", "quoted text"},
      {"output: {polar: {gain: 1}}", "4:18: output.polar.gain:", "this map has no keys"},
      {"output: {png: {db: [0]}}", "4:20: output.png.db:", "a list of 2 numbers"},
      {"output: {png: {db: [0, 1, 2]}}", "4:20: output.png.db:", "a list of 2 numbers"},
      {"output: {png: {db: [0, x]}}", "4:24: output.png.db.1:", "`x` is not a number"},
      {"output: {png: {db: [10, 10]}}", "4:20: output.png.db:", "black below white"},
      {"output: {png: {resampling: nearst}}",
       "4:28: output.png.resampling:", "did you mean nearest?"},
      {"output: {png: {resampling: area}}",
       "4:28: output.png.resampling:", "expected one of bilinear, nearest"},
      {"output: [1]", "4:9: output:", "found a list; expected a map with timeseries"},
      {"objects: {a: 1}", "4:10: objects:", "found a map; expected a list"},
      {"objects: [1]", "4:11: objects.0:", "expected a map with name"},
      {"materials: [1]", "4:12: materials:", "expected a map of names"},
      {"noise: {}", "4:8: noise:", "missing; expected either spectrum_level_db"},
      {"synthesis: {tolerance: 1e-2}", "4:24: synthesis.tolerance:", "from 1e-07 to 0.001"},
      {"synthesis: {tolerance: 1e-8}", "4:24: synthesis.tolerance:", "from 1e-07 to 0.001"},
      {"noise:", "4:1: noise:", "found nothing"},
      {"splits: {train: 0, val: 0}", "4:9: splits:", "a sum above zero"},
      {"splits: {train: -0.1, val: 1}", "4:17: splits.train:", "from 0 to"},
  });
  const auto lines = faults_of(kHead +
                               "objects: [{name: a, material: m, shape: {sphere: {radius_m: 1, "
                               "inward_facing: on}}}]\nmaterials: {m: {reflectivity: 1}}\n");
  CHECK(tells(lines, "t.yaml:4:79: objects.0.shape.sphere.inward_facing:", "true or false"));
}

// Protects the head: the format version decides how everything else is read.
TEST_CASE("format version and names are checked") {
  const std::string sonar = "sonar: {preset: blueview_p900_90}\n";
  CHECK(tells(faults_of("ensonify: 2\nname: t\n" + sonar), "t.yaml:1:11: ensonify:", "expected 1"));
  CHECK(tells(faults_of("ensonify: 01\nname: t\n" + sonar),
              "t.yaml:1:11: ensonify:", "octal number"));
  CHECK(tells(faults_of("name: t\n" + sonar), "t.yaml:1:1: ensonify:", "missing; expected 1"));
  const auto name_fault = [&](const std::string& name) {
    return faults_of("ensonify: 1\nname: " + name + "\n" + sonar);
  };
  CHECK(name_fault("\"010\"").empty());
  CHECK(name_fault("käse und brot").empty());
  for (const char* name : {"010", "7", "1e3", "yes", "off", "true", "~", "", "\"\"", "\"a\\tb\"",
                           "\"a\\x85\"", "\"\\u2028\"", "[a]", "{a: 1}", "1:30"}) {
    INFO(name);
    const auto lines = name_fault(name);
    CHECK(lines.size() == 1);
    const std::string place = *name == '\0' ? "t.yaml:2:1: name:" : "t.yaml:2:7: name:";
    CHECK(tells(lines, place, "expected printable text of 1 to 128 bytes"));
  }
  CHECK(name_fault(std::string(128, 'a')).empty());
  CHECK(tells(name_fault(std::string(129, 'a')), "t.yaml:2:7: name:", "longer than 128 bytes"));
}

// Protects users with scenarios of earlier versions: a key under its earlier name is one error,
// which gives the current name, and that key is not reported as missing too.
TEST_CASE("a renamed key is an error that gives its current name") {
  const std::string object =
      "materials: {m: {reflectivity: 1}}\nobjects: [{name: a, material: m, shape: ";
  check_single_faults({
      {"trajectory: {jitter: {period_s: 5}}",
       "4:22: trajectory.jitter:", "this key was renamed; expected wave_motion"},
      {"output: {pack: sequence}",
       "4:16: output.pack:", "this key was renamed; expected one_file_per"},
      {object + "{sphere: {radius_m: 1, inside: true}}}]",
       "5:72: objects.0.shape.sphere.inside:", "this key was renamed; expected inward_facing"},
      {object + "{box: {size_m: [1, 1, 1], inside: true}}}]",
       "5:75: objects.0.shape.box.inside:", "this key was renamed; expected inward_facing"},
  });
  const auto lines = faults_of(
      "ensonify: 1\nsonar:\n  frequency_hz: 9e5\n  bandwidth_hz: 3e4\n  source_level_db: 200\n"
      "  range_max_m: 10\n  beams: {count: 8, fov_deg: 80, width_deg: 1}\n"
      "  elevation: {width_deg: 20}\n  rays: {elevation: 8, per_cell: 10}\n");
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 2);
  CHECK(tells(lines, "t.yaml:7:",
              "sonar.beams.width_deg: this key was renamed; expected receive_width_deg"));
  CHECK(tells(lines,
              "t.yaml:9:", "sonar.rays.per_cell: this key was renamed; expected min_per_cell"));
}

// Protects references between the parts of a world, and what its masks can hold.
TEST_CASE("objects are checked against materials and each other") {
  const std::string steel = "materials: {steel: {reflectivity: 1e-2}}\n";
  const std::string plane = ", shape: {plane: {}}}\n";
  check_single_faults({
      {steel + "objects: [{name: a, material: stel" + plane.substr(0, plane.size() - 1) + "]",
       "5:31: objects.0.material:", "no material `stel` (did you mean steel?)"},
      {"objects: [{name: a, material: steel, shape: {plane: {}}}]",
       "4:31: objects.0.material:", "expected one that is defined under materials"},
      {steel + "objects:\n  - {name: a, material: steel" + plane + "  - {name: a, material: steel" +
           plane,
       "7:12: objects.1.name:", "the name `a` is already used by objects.0.name"},
      {steel + "objects:\n  - {name: a, material: steel" + plane +
           "point_targets: [{name: a, target_strength_db: 0, position_m: [0, 0, 0]}]",
       "7:24: point_targets.0.name:", "the name `a` is already used by objects.0.name"},
      {steel + "objects:\n  - {name: a, material: steel, shape: {}}",
       "6:39: objects.0.shape:", "missing; expected one of box"},
      {steel + "objects:\n  - {name: a, material: steel}", "6:5: objects.0.shape:", "missing"},
      {steel +
           "objects:\n  - {name: a, material: steel, shape: {plane: {}, sphere: {radius_m: 1}}}",
       "6:51: objects.0.shape:", "plane, sphere exclude each other"},
      {steel + "objects:\n  - {name: a, material: steel, shape: {box: {size_m: [1, 0, 1]}}}",
       "6:58: objects.0.shape.box.size_m.1:", "a number > 0"},
      {steel + "objects:\n  - {name: a, material: steel, shape: {cylinder: {radius_m: 1}}}",
       "6:50: objects.0.shape.cylinder.height_m:", "missing"},
      {"materials: {steel: {}}", "4:20: materials.steel:", "either reflectivity"},
      {"materials: {010: {reflectivity: 1}}", "4:13: materials.010:", "unless it is quoted"},
      {"materials: {a: {reflectivity: -1}}", "4:31: materials.a.reflectivity:", "from 0 to"},
      {"point_targets: [{name: a, position_m: [0, 0, 0]}]",
       "4:17: point_targets.0:", "missing"},
      {"point_targets: [{name: a, target_strength_db: 0}]",
       "4:17: point_targets.0.position_m:", "missing"},
  });
}

std::string many_targets(int count, int classes) {
  std::string text = "point_targets:\n";
  for (int i = 0; i < count; ++i) {
    text += "- {name: p";
    text += std::to_string(i);
    text += ", class: c";
    text += std::to_string(i % classes);
    text += ", target_strength_db: 0, position_m: [0, 0, 0]}\n";
  }
  return text;
}

// Protects the masks: 8 bits of classes, 16 bits of instances less the two that mean something.
TEST_CASE("classes and instances beyond the masks are refused", "[figure]") {
  CHECK(faults_of(kHead + many_targets(255, 255)).empty());
  const auto classes = faults_of(kHead + many_targets(256, 256));
  CHECK(
      tells(classes, "t.yaml:260:23: point_targets.255.class:", "more than 255 different classes"));
  CHECK(faults_of(kHead + many_targets(65534, 1)).empty());
  const auto instances = faults_of(kHead + many_targets(65535, 1));
  CHECK(tells(instances,
              "t.yaml:5:1: point_targets:", "more than 65534 objects, point targets and volumes"));
  // Volumes share the ids and classes.
  const std::string volume = "volumes: [{name: v, uniform: {strength_db: 0}}]";
  const auto with_volume = faults_of(kHead + many_targets(255, 255) + volume);
  CHECK(with_volume.size() == 1);
  CHECK(tells(with_volume, "t.yaml:260:11: volumes.0:", "more than 255 different classes"));
  std::string volumes = "volumes:\n";
  for (int i = 0; i < 65535; ++i) {
    volumes += "- {name: v" + std::to_string(i) + ", uniform: {strength_db: 0}}\n";
  }
  CHECK(
      tells(faults_of(kHead + volumes), "t.yaml:5:1: volumes:", "more than 65534 objects, point"));
}

// Protects the path of the sonar: interpolation needs times that increase.
TEST_CASE("poses are checked") {
  check_single_faults({
      {"trajectory: {poses: []}", "4:21: trajectory.poses:", "at least one pose"},
      {"trajectory:\n  poses:\n    - {time_s: 0}\n    - {time_s: 1}\n    - {time_s: 1}",
       "8:16: trajectory.poses.2.time_s:", "1 s is not after the 1 s of the pose before"},
      {"trajectory: {poses: [{time_s: 0}, {}]}", "4:35: trajectory.poses.1.time_s:", "missing"},
      {"trajectory: {poses: [{rotation_deg: [0, 0, 0], quaternion_wxyz: [1, 0, 0, 0]}]}",
       "4:48: trajectory.poses.0:", "exclude each other"},
      {"trajectory: {poses: [{quaternion_wxyz: [0, 0, 0, 0]}]}",
       "4:40: trajectory.poses.0.quaternion_wxyz:", "has no length"},
      {"trajectory: {poses: [{quaternion_wxyz: [1, 0, 0]}]}",
       "4:40: trajectory.poses.0.quaternion_wxyz:", "a list of 4 numbers"},
      {"trajectory: {poses: [{}], file: a.csv}", "4:27: trajectory:", "poses, file exclude"},
  });
}

// Protects the water: one way of giving the absorption, with what belongs to it.
TEST_CASE("absorption is fixed or a model") {
  check_single_faults({
      {"water: {absorption: {}}", "4:21: water.absorption:", "fixed_db_m (dB/m) or model"},
      {"water: {absorption: {ph: 8}}", "4:21: water.absorption:", "fixed_db_m (dB/m) or model"},
      {"water: {absorption: {fixed_db_m: 0.1, ph: 8}}",
       "4:43: water.absorption.ph:", "has no effect"},
      {"water: {absorption: {fixed_db_m: 0.1, model: francois_garrison}}",
       "4:39: water.absorption:", "exclude each other"},
      {"water: {absorption: {model: ainslie_mccol}}",
       "4:29: water.absorption.model:", "one of francois_garrison, ainslie_mccolm"},
      {"water: {absorption: {fixed_db_m: -1}}", "4:34: water.absorption.fixed_db_m:", "from 0 to"},
  });
}

// Protects the promise that one run tells every fault, in the order of the file.
TEST_CASE("all faults are told at once, in the order of the file") {
  const auto lines = faults_of(
      "ensonify: 1\nname: 5\nseed: x\nseed: 1\nsonr: {}\nsonar: {preset: nope}\n"
      "materials: {a: {reflectivity: 010}}\nobjects: [{name: o, material: b, shape: {plain: "
      "{}}}]\n");
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 9);
  const std::vector<std::string> begins = {"2:7: name:",
                                           "3:7: seed:",
                                           "4:1: seed: the key is given twice",
                                           "5:1: sonr:",
                                           "6:17: sonar.preset:",
                                           "7:31: materials.a.reflectivity:",
                                           "8:31: objects.0.material:",
                                           "8:41: objects.0.shape:",
                                           "8:42: objects.0.shape.plain:"};
  for (std::size_t i = 0; i < begins.size(); ++i) {
    CHECK(lines[i].starts_with("t.yaml:" + begins[i]));
  }
}

// Protects a terminal against a file of nothing but faults.
TEST_CASE("faults beyond a hundred are counted only") {
  std::string unknown = kHead;
  std::string wrong = kHead + "materials:\n";
  for (int i = 0; i < 150; ++i) {
    unknown.append("k").append(std::to_string(i)).append(": 1\n");
    wrong.append("  m").append(std::to_string(i)).append(": {reflectivity: x}\n");
  }
  for (const std::string& text : {unknown, wrong}) {
    const auto lines = faults_of(text);
    REQUIRE(lines.size() == 101);
    CHECK(lines.back() == "and 50 more");
  }
}

// Protects the other faults of a file against an entry with a count, whose copies are all wrong in
// the same way. Found by a fuzzer, which waited for the words of 560,000 faults.
TEST_CASE("what is wrong with all copies of an entry is told once") {
  const std::string entry =
      kHead +
      "objects:\n"
      "  - {name: block, count: 60000, material: concret, place: {on: flor, area_m: [[0, 0], [1, "
      "1]]},"
      " shape: {box: {size_m: [{uniform: [1, nan]}, {uniform: [b, 2]}, 1], siz: 1}}}\n"
      "trajectory: {pings: 0}\n";
  const auto lines = faults_of(entry);
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 6);
  CHECK(tells(lines, "t.yaml:5:43: objects.0.material:", "no material `concret`"));
  CHECK(tells(lines, "t.yaml:5:64: objects.0.place.on:", "no object `flor`"));
  CHECK(tells(lines, "t.yaml:5:134: objects.0.shape.box.size_m.0.uniform.1:", "not finite"));
  CHECK(
      tells(lines, "t.yaml:5:152: objects.0.shape.box.size_m.1.uniform.0:", "`b` is not a number"));
  CHECK(tells(lines, "t.yaml:5:164: objects.0.shape.box.siz:", "unknown key"));
  CHECK(tells(lines, "t.yaml:6:21: trajectory.pings:", "out of range"));
}

// Protects the same of a fault that not every copy has: it is told of the first one that has it,
// and two faults of one place are two.
TEST_CASE("what is wrong with some copies of an entry is told") {
  const auto lines =
      faults_of(kHead +
                "point_targets:\n"
                "  - {name: p, count: 50, target_strength_db: {uniform: [1, {choice: [0, 2]}]},"
                " position_m: [1, 0, 0]}\n");
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 1);
  CHECK(tells(lines, "t.yaml:5:56: point_targets.0.target_strength_db.uniform:", "1 is above 0"));
}

}  // namespace
}  // namespace ensonify
