// Values that several keys share, `variables`.
#include <algorithm>
#include <cmath>
#include <set>

#include "catch.h"
#include "core/random.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::tells;

Scenario computed(const std::string& added, std::uint32_t sequence = 0,
                  const std::vector<Override>& overrides = {}) {
  INFO(added);
  return value_of(parse_scenario(kHead + added, "t.yaml", ".", overrides, sequence));
}

std::string text_of(Scenario scenario) {
  scenario.drawn_sections = nullptr;
  return emit(scenario);
}

std::string draw_of(const Scenario& scenario, const std::string& path) {
  for (const DrawnValue& draw : scenario.draws) {
    if (draw.path == path) return draw.value;
  }
  return "";
}

const std::string kShared = R"(variables:
  depth: {uniform: [2.0, 9]}
  halves: {uniform: [1, 5]}
  site: {choice: [{speed: 1490, bottom: sand}, {speed: {uniform: [1510.0, 1520]}, bottom: mud}]}
  sum: "= depth + 1"
materials: {sand: {reflectivity: 1e-3}, mud: {reflectivity: 1e-4}}
water: {sound_speed_m_s: $site.speed}
objects:
  - {name: floor, material: $site.bottom, class: $site.bottom, shape: {plane: {}}, pose: {position_m: [0, 0, "= -depth"]}}
  - {name: ball, count: $halves, material: sand, shape: {sphere: {radius_m: "= 0.1 * halves"}}, pose: {position_m: [{uniform: [1.0, $depth]}, 0, 0]}}
point_targets:
  - {name: p, target_strength_db: {normal: [-30, 2]}, position_m: [$sum, $depth, 0]}
)";

}  // namespace

// Protects what variables are for: keys that use one have the same value in each sequence, by all
// forms of use, and it differs between sequences.
TEST_CASE("keys that use a variable share one draw") {
  std::set<double> depths;
  std::set<std::size_t> counts;
  std::set<std::string> bottoms;
  for (std::uint32_t sequence = 0; sequence < 100; ++sequence) {
    const Scenario scenario = computed(kShared, sequence);
    const double depth = scenario.point_targets[0].position_m[1];
    CHECK(depth >= 2);
    CHECK(depth <= 9);
    CHECK(scenario.objects[0].pose.position_m[2] == -depth);
    CHECK(scenario.point_targets[0].position_m[0] == depth + 1);
    const std::size_t balls = scenario.objects.size() - 1;
    REQUIRE(balls >= 1);
    CHECK(std::get<SphereSpec>(scenario.objects[1].shape).radius_m ==
          Approx(0.1 * static_cast<double>(balls)).epsilon(1e-15));
    CHECK(scenario.objects[1].pose.position_m[0] <= depth);
    const bool is_sand = scenario.water.sound_speed_m_s == 1490;
    CHECK(scenario.objects[0].material == (is_sand ? "sand" : "mud"));
    CHECK((is_sand || scenario.water.sound_speed_m_s >= 1510));
    CHECK(scenario.class_names ==
          std::vector<std::string>{"sand", "mud", "object", "point_target"});
    depths.insert(depth);
    counts.insert(balls);
    bottoms.insert(scenario.objects[0].material);
  }
  CHECK(depths.size() == 100);
  CHECK(counts == std::set<std::size_t>{1, 2, 3, 4, 5});
  CHECK(bottoms.size() == 2);
}

// Protects the record of a data set: a variable is one entry, and keys that use it are none.
TEST_CASE("a variable is recorded once") {
  const Scenario scenario = computed(kShared, 3);
  std::vector<std::string> paths;
  for (const DrawnValue& draw : scenario.draws) paths.push_back(draw.path);
  CHECK(std::count(paths.begin(), paths.end(), "variables.depth") == 1);
  CHECK(std::is_sorted(paths.begin(), paths.end()));
  CHECK(std::stod(draw_of(scenario, "variables.depth")) == scenario.point_targets[0].position_m[1]);
  CHECK(draw_of(scenario, "point_targets.p.position_m.1") == "");
  CHECK(draw_of(scenario, "variables.site.choice") ==
        (scenario.objects[0].material == "sand" ? "0" : "1"));
}

// Protects data sets that grow: draws of other keys and variables do not depend on a variable.
TEST_CASE("a new variable changes no other draw") {
  std::string more = kShared;
  more.insert(std::string("variables:\n").size(), "  first: {uniform: [0.0, 1]}\n");
  for (std::uint32_t sequence = 0; sequence < 100; ++sequence) {
    CHECK(text_of(computed(more, sequence)) == text_of(computed(kShared, sequence)));
  }
  const std::string plain =
      "point_targets: [{name: p, target_strength_db: {normal: [-30, 2]}, position_m: [1, 2, 3]}]\n";
  CHECK(text_of(computed("variables: {x: {uniform: [0.0, 1]}}\n" + plain, 4)) ==
        text_of(computed(plain, 4)));
}

// An independent route to the value: the key of a draw is the hash of its path.
TEST_CASE("a variable is drawn by the key of its path") {
  const std::uint64_t seed_key = stream_key(0, Stream::world, SequenceDraw(7));
  const std::uint64_t top = mix64(0 ^ name_key("variables"));
  const double u = uniform(seed_key, 0, mix64(top ^ name_key("x")), 0);
  const Scenario scenario =
      computed("variables: {x: {uniform: [0.0, 4]}}\nwater: {absorption: {fixed_db_m: $x}}\n", 7);
  CHECK(std::get<FixedAbsorptionSpec>(scenario.water.absorption).db_m == 4 * u);
}

// Protects a data set's own scenario.yaml.
TEST_CASE("the resolved text keeps variables and draws the same again") {
  const std::string text = emit(computed(kShared));
  CHECK(contains(text, "variables:\n  depth: {uniform: [2.0, 9]}\n"));
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    INFO(text);
    const auto again = value_of(parse_scenario(text, "again.yaml", ".", {}, sequence));
    CHECK(emit(again) == text);
    CHECK(text_of(again) == text_of(computed(kShared, sequence)));
    CHECK(again.draws == computed(kShared, sequence).draws);
  }
}

// A scenario whose variables are plain values is the one that has these values at its keys.
TEST_CASE("plain variables stand for themselves") {
  const Scenario by_name = computed(
      "variables: {z: 3, at: [1, 2, $z]}\n"
      "point_targets: [{name: p, target_strength_db: \"=-40\", position_m: $at}]\n");
  const Scenario plain =
      computed("point_targets: [{name: p, target_strength_db: -40, position_m: [1, 2, 3]}]\n");
  CHECK(text_of(by_name) == text_of(plain));
  CHECK_FALSE(by_name.has_draws);
}

TEST_CASE("variables can be set from the command line") {
  const Scenario set = computed(kShared, 0, {{"variables.depth", "3"}});
  CHECK(set.point_targets[0].position_m[1] == 3);
  CHECK(draw_of(set, "variables.depth") == "");
  const Scenario narrowed = computed(kShared, 0, {{"variables.depth.uniform", "[4.0, 4.5]"}});
  CHECK(narrowed.point_targets[0].position_m[1] >= 4);
  CHECK(narrowed.point_targets[0].position_m[1] <= 4.5);
  // No name excludes another, as keys of a sonar do.
  const Scenario named =
      computed("variables: {fov_deg: 2}\nwater: {absorption: {fixed_db_m: $fov_deg}}\n", 0,
               {{"variables.spacing_deg", "3"}});
  CHECK(std::get<FixedAbsorptionSpec>(named.water.absorption).db_m == 2);
}

TEST_CASE("wrong uses of variables are told with their places") {
  const std::string depth = "variables: {depth: 3, word: mud, map: {a: 1}}\n";
  check_single_faults({
      {depth + "water: {sound_speed_m_s: $dept}", "5:26: water.sound_speed_m_s: ",
       "no variable `dept` (did you mean depth?); expected one of variables: depth, map, word"},
      {"water: {sound_speed_m_s: $depth}",
       "4:26: water.sound_speed_m_s: ", "expected one that is defined under variables"},
      {depth + "water: {sound_speed_m_s: $depth}", "5:26: water.sound_speed_m_s: ",
       "expected a number from 100 to 10000 (from variables.depth)"},
      {depth + "water: {sound_speed_m_s: $word}", "5:26: water.sound_speed_m_s: ",
       "`mud` is not a number; expected a number from 100 to 10000 (from variables.word)"},
      {depth + "water: {sound_speed_m_s: $map.b}",
       "5:26: water.sound_speed_m_s: ", "variables.map has no key `b`"},
      {depth + "water: {sound_speed_m_s: \"= 5 * word\"}", "5:26: water.sound_speed_m_s: ",
       "variables.word is `mud`; expected a number in an expression"},
      {depth + "water: {sound_speed_m_s: \"= 5 * (depth\"}",
       "5:26: water.sound_speed_m_s: ", "expected an expression"},
      {depth + "water: {sound_speed_m_s: \"= depth = 5\"}",
       "5:26: water.sound_speed_m_s: ", "expected an expression"},
      {depth + "water: {sound_speed_m_s: \"= 1 / 0\"}",
       "5:26: water.sound_speed_m_s: ", "not a finite number"},
      {depth + "water: {sound_speed_m_s: \"= 5 * dept\"}",
       "5:26: water.sound_speed_m_s: ", "(did you mean depth?)"},
      {"variables: {a: $b, b: 3}\nwater: {sound_speed_m_s: $a}",
       "4:16: variables.a: ", "no variable `b`"},
      {"variables: {a: {uniform: [3, 1]}}\nwater: {sound_speed_m_s: $a, absorption: {fixed_db_m: "
       "\"= 2 * a\"}}",
       "4:26: variables.a.uniform: ", "3 is above 1"},
      {"variables: {2a: 3}\n", "4:13: variables.2a: ", "not a name for a variable"},
      {"variables: [3]\n", "4:12: variables: ", "not a map; expected a map of names"},
      {"variables: {choice: [{a: 1}, {a: 2}]}\n",
       "4:12: variables: ", "not a map; expected a map of names"},
      {depth + "sequences: $depth", "5:12: sequences: ", "cannot be a variable"},
      {depth + "point_targets: [{name: $word, target_strength_db: 0, position_m: [1, 0, 0]}]",
       "5:24: point_targets.0.name: ", "cannot be a variable"},
      {depth + "trajectory: {file: {choice: [$word]}}",
       "5:30: trajectory.file.choice.0: ", "a file cannot be named by a variable"},
  });
}

// Protects "checked before it runs": the ends of a variable at each of its uses, the alternatives
// of a choice too.
TEST_CASE("the extremes of variables are checked where they are used") {
  const auto checked = [](const std::string& added) {
    return message_of(check_draws(kHead + added, "t.yaml", "."));
  };
  CHECK(checked(kShared) == "");
  const std::string far = checked(
      "variables: {x: {uniform: [1, 900]}}\n"
      "water: {absorption: {fixed_db_m: $x}}\n"
      "noise: {snr_db: \"= x - 100\"}\n");
  INFO(far);
  CHECK(contains(far, "t.yaml:6:17: noise.snr_db: `799.999"));
  CHECK(contains(far, "(from variables.x)"));
  CHECK_FALSE(contains(far, "fixed_db_m"));
  const std::string third = checked(
      "variables: {s: {choice: [{v: 1500}, {v: 1510}, {v: 5}]}}\n"
      "water: {sound_speed_m_s: $s.v}\n");
  INFO(third);
  CHECK(third.find("t.yaml:5:26: water.sound_speed_m_s: `5` is out of range") == 0);
}

// Protects memory: variables of variables grow by a power with each line.
TEST_CASE("variables cannot stand for a world without end") {
  std::string text = "variables:\n  a0: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "$a" + std::to_string(i - 1);
    text += "  a" + std::to_string(i) + ": [";
    for (int k = 0; k < 10; ++k) text += (k > 0 ? ", " : "") + before;
    text += "]\n";
  }
  const auto lines = faults_of(kHead + text);
  INFO(joined_lines(lines));
  CHECK(tells(lines, "t.yaml:", "variables stand for more than 250000 values; expected fewer"));
}

}  // namespace ensonify
