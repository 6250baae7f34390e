// sonar.receiver with an array: what is read, refused, drawn and written again.
#include "scenario_texts.h"

namespace ensonify {
namespace {

using namespace testing;

std::string with_receiver(const std::string& keys, const std::string& more = "") {
  return "ensonify: 1\nname: t\nsonar: {preset: blueview_p900_90, receiver: {" + keys + "}}\n" +
         more;
}

ArraySpec array_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  INFO(text);
  const auto scenario = value_of(parse(text, overrides));
  REQUIRE(scenario.sonar.array.has_value());
  return *scenario.sonar.array;
}

const std::string kAll =
    "mode: array, elements: 40, spacing_m: 1e-3, element_width_m: 5e-4, shading: {taylor: "
    "{side_lobe_db: -25}}, focus: none, steering: phase, gain_error_db: 0.5, phase_error_deg: 4, "
    "dead: [3, 0, 39]";

}  // namespace

TEST_CASE("an array is read with its defaults") {
  const ArraySpec array = array_of(with_receiver("mode: array"));
  CHECK_FALSE(array.elements);
  CHECK_FALSE(array.spacing_m);
  CHECK_FALSE(array.shading);
  CHECK(array.element_width_m == 0);
  CHECK(array.focus == Focus::dynamic);
  CHECK(array.steering == Steering::true_delay);
  CHECK(array.dead.empty());
  CHECK_FALSE(parse(with_receiver("mode: beams"))->sonar.array);
  CHECK_FALSE(parse(kHead)->sonar.array);
}

TEST_CASE("an array is read with all its keys") {
  const ArraySpec array = array_of(with_receiver(kAll));
  CHECK(array.elements == 40);
  CHECK(array.spacing_m == 1e-3);
  CHECK(array.element_width_m == 5e-4);
  CHECK(array.shading->kind == Shading::taylor);
  CHECK(array.shading->side_lobe_db == -25);
  CHECK(array.focus == Focus::none);
  CHECK(array.steering == Steering::phase);
  CHECK(array.gain_error_db == 0.5);
  CHECK(array.phase_error_deg == 4);
  CHECK(array.dead == std::vector<int>{3, 0, 39});
}

// Protects the resolved scenario: what was given stays, what was left out may be worked out again.
TEST_CASE("a resolved array reads back to the same text") {
  for (const std::string& keys :
       {std::string("mode: array"), kAll, kAll + ", adc: {bits: 12, full_scale_db: 170}"}) {
    const std::string resolved = emit(*parse(with_receiver(keys)));
    INFO(resolved);
    CHECK(contains(resolved, "mode: array"));
    CHECK(emit(*parse(resolved)) == resolved);
  }
  const std::string derived = emit(*parse(with_receiver("mode: array")));
  CHECK_FALSE(contains(derived, "elements"));
  CHECK_FALSE(contains(derived, "spacing_m"));
  CHECK(emit(*parse(with_receiver("mode: beams"))) == emit(*parse(with_receiver(""))));
  const std::string channels =
      emit(*parse(with_receiver("mode: array", "output: {channels: true}\n")));
  CHECK(contains(channels, "channels: true"));
  CHECK(emit(*parse(channels)) == channels);
  CHECK_FALSE(contains(derived, "channels"));
}

TEST_CASE("wrong arrays are told with their place") {
  check_single_faults(
      {
          {"mode: line", "sonar.receiver.mode:", "one of beams, array"},
          {"elements: 4", "sonar.receiver.elements:", "has no effect with mode: beams"},
          {"mode: beams, focus: none", "sonar.receiver.focus:", "has no effect with mode: beams"},
          {"mode: array, elements: 0", "sonar.receiver.elements:", "an integer from 1 to 4096"},
          {"mode: array, elements: 4097", "sonar.receiver.elements:", "an integer from 1 to 4096"},
          {"mode: array, spacing_m: 0", "sonar.receiver.spacing_m:", "a number > 0"},
          {"mode: array, focus: far", "sonar.receiver.focus:", "one of none, dynamic"},
          {"mode: array, steering: delay", "sonar.receiver.steering:", "one of true_delay, phase"},
          {"mode: array, shading: tailor", "sonar.receiver.shading:", "did you mean taylor?"},
          {"mode: array, gain_error_db: -1", "sonar.receiver.gain_error_db:", "from 0 to 40"},
          {"mode: array, dead: 3", "sonar.receiver.dead:", "list"},
          {"mode: array, dead: [-1]", "sonar.receiver.dead.0:", "from 0 to 4095"},
          {"mode: array, dead: [1.5]", "sonar.receiver.dead.0:", "not an integer"},
          {"mode: array, dead: [1, 2, 1]", "sonar.receiver.dead:", "element 1 is listed twice"},
          {"mode: array, elements: 4, dead: [4]", "sonar.receiver.dead:", "expected 0 to 3"},
          {"mode: array, elements: 2, dead: [1, 0]", "sonar.receiver.dead:", "all 2 elements"},
          {"mode: array, element: 4", "sonar.receiver.element:", "did you mean elements?"},
      },
      [](const std::string& keys) { return with_receiver(keys); });
}

TEST_CASE("what does not go with an array, or needs one, is told") {
  const auto scale =
      faults_of(with_receiver("mode: array", "scattering: {normalization: mean_square}\n"));
  CHECK(scale.size() == 1);
  CHECK(tells(scale, "t.yaml:4:29: scattering.normalization:", "calibrated"));
  const auto channels = faults_of(kHead + "output: {channels: true}\n");
  CHECK(channels.size() == 1);
  CHECK(tells(channels, "t.yaml:4:20: output.channels:", "sonar.receiver.mode: array"));
  CHECK(faults_of(kHead + "output: {channels: false}\n").empty());
}

TEST_CASE("an override changes the receiver's mode and shading") {
  const auto beams = value_of(parse(with_receiver(kAll), {{"sonar.receiver.mode", "beams"}}));
  CHECK_FALSE(beams.sonar.array);
  const ArraySpec shaded = array_of(with_receiver("mode: array, shading: hann"),
                                    {{"sonar.receiver.shading.taylor.nbar", "7"}});
  CHECK(shaded.shading->kind == Shading::taylor);
  CHECK(shaded.shading->nbar == 7);
}

// Protects drawn instruments: whole numbers where they are read, lists as a whole or item by item.
TEST_CASE("an array's values can be drawn") {
  const std::string text = with_receiver(
      "mode: array, elements: {uniform: [8, 12]}, focus: {choice: [none, dynamic]}, "
      "gain_error_db: {uniform: [0, 2]}, dead: {choice: [[], [1, {uniform: [2, 7]}]]}");
  bool some_dead = false, none_dead = false;
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const auto scenario = value_of(parse_scenario(text, "t.yaml", ".", {}, sequence));
    const ArraySpec& array = *scenario.sonar.array;
    CHECK((*array.elements >= 8 && *array.elements <= 12));
    (array.dead.empty() ? none_dead : some_dead) = true;
    CHECK(emit(scenario) == emit(*parse(text)));
  }
  CHECK((some_dead && none_dead));
}

}  // namespace ensonify
