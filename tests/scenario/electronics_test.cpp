// The keys of the electronics, the detector and the recorder.
#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::parse;
using testing::read_again;

std::string chain_text(const std::string& keys, const std::string& more = "") {
  return "ensonify: 1\nname: t\nsonar: {preset: blueview_p900_90, " + keys + "}\n" + more;
}

}  // namespace

TEST_CASE("a scenario without electronics has none") {
  const auto scenario = value_of(parse(chain_text("range_max_m: 20")));
  CHECK_FALSE(scenario.sonar.electronics);
  CHECK_FALSE(scenario.sonar.recorder);
  CHECK_FALSE(sonar_of(scenario).detector);
  CHECK_FALSE(contains(emit(scenario), "detector"));
  CHECK_FALSE(sonar_of(scenario).front_end);
  CHECK_FALSE(scenario.output.selection.artifact);
  CHECK_FALSE(scenario.noise_correlated);
}

// Protects each key: its place in the structs, and the resolved text, which gives them again.
TEST_CASE("the keys of electronics and recorder are read and written") {
  const std::string text = chain_text(
      "electronics: {beam_gain_error_db: 0.5, beam_phase_error_deg: 4, crosstalk_db: -33, leakage: "
      "{level_db: 170, decay_m: 0.3}, interference: {level_db: 120, ping_rate_hz: 7, duration_s: "
      "1e-3, azimuth_deg: -30}, blanking_m: 0.7, saturation: {level_db: 165, streak_db: -12, "
      "streak_m: 2}}, detector: {looks: 3, floor_db: 60, noise_db: 2.5, integrate: 1.5, law: "
      "logarithm}, recorder: {bits: 16, scale: amplitude, db: [0, 170], gamma: 0.7, row_gain_db: "
      "20, tvg: {spreading: 30, absorption: true, step_db: 2}, range_gain: {level_db: 100, "
      "attack_m: 0.2, release_m: 3, max_gain_db: 30}, dropped: 0.1}",
      "noise: {spectrum_level_db: 40, correlated: true}\n");
  const auto scenario = value_of(parse(text));
  const FrontEnd front = *sonar_of(scenario).front_end;
  CHECK(front.interference->azimuth_rad == Approx(radians(-30)));
  CHECK(front.saturation->streak_db == -12.0);
  CHECK(front.blanking_m == 0.7);
  const Detector detector = *sonar_of(scenario).detector;
  CHECK(detector.looks == 3);
  CHECK(detector.floor_db == 60.0);
  CHECK(detector.noise_db == 2.5);
  CHECK(detector.integrate == 1.5);
  CHECK(detector.law == DetectorLaw::logarithm);
  CHECK(scenario.sonar.recorder->recorder.spreading == 30);
  CHECK(scenario.sonar.recorder->recorder.range_gain->release_m == 3);
  CHECK(scenario.sonar.recorder->dropped == 0.1);
  CHECK(scenario.noise_correlated);
  CHECK(scenario.output.selection.artifact);
  const std::string resolved = emit(scenario);
  read_again(scenario);
  CHECK(contains(resolved, "row_gain_db: 20"));
}

TEST_CASE("groups of beams are read and written") {
  const std::string text = chain_text(
      "beams: {count: 96, fov_deg: 48}, transmit: {groups: 4, order: [2, 0, 3, 1], interval_s: "
      "0.02, width_deg: 0.4, level_db: [-0.5, 0, 0.2, 1], level_error_db: 0.3}, electronics: "
      "{beam_gain_error_db: [0.5, 0.7], "
      "crosstalk_db: [-4.9, -6.8, -8.3]}");
  const auto scenario = value_of(parse(text));
  const Sonar sonar = sonar_of(scenario);
  CHECK(sonar.transmit->order == std::vector{2, 0, 3, 1});
  CHECK(fired_after_s(sonar, 3) == 0.04);
  CHECK(sonar.transmit->width_rad == Approx(radians(0.4)));
  CHECK(sonar.transmit->level_db == std::vector{-0.5, 0.0, 0.2, 1.0});
  CHECK(sonar.front_end->crosstalk_db.values == std::vector{-4.9, -6.8, -8.3});
  CHECK(sonar.front_end->ping_gain_error_db == 0.7);
  read_again(scenario);
  CHECK(contains(emit(scenario), "beam_gain_error_db: [0.5, 0.7]"));
  const auto sectors = value_of(parse(chain_text(
      "beams: {count: 96, fov_deg: 48}, transmit: {sectors: [30, 40, 26], frequency_hz: [8e5, 9e5, "
      "1e6], turnaround_s: 0.001}")));
  read_again(sectors);
  const Sonar swath = sonar_of(sectors);
  CHECK(group_of(swath, 29) == 0);
  CHECK(group_of(swath, 30) == 1);
  CHECK(carrier_of_beam_hz(swath, 95) == 1e6);
  CHECK(beams_of_group(swath, 2).first == 70);
  // Left out: in ascending order, as wide as the receive beam.
  const auto plain = value_of(parse(chain_text("transmit: {groups: 4}")));
  CHECK(plain.sonar.transmit->groups.order == std::vector{0, 1, 2, 3});
  CHECK(sonar_of(plain).transmit->width_rad == 0);
  CHECK(fired_after_s(sonar_of(plain), 3) == 0);
  CHECK_FALSE(contains(emit(plain), "order:"));
}

TEST_CASE("groups that do not fit the beams are errors with their place") {
  const auto with = [](const char* keys) {
    return chain_text("beams: {count: 96, fov_deg: 48}, transmit: {" + std::string(keys) + "}");
  };
  testing::check_single_faults(
      {
          {with("groups: 7"), "",
           "sonar.transmit.groups: 7 groups do not divide 96 beams; "
           "expected one of 1, 2, 3, 4, 6, 8, 12"},
          {with("interval_s: 0.1"), "", "groups: missing"},
          {with("sectors: [40, 50]"), "", "sonar.transmit.sectors: the sectors have 90 beams, but"},
          {with("groups: 2, sectors: [48, 48]"), "", "sectors"},
          {with("sectors: [48, 48], frequency_hz: [9e5]"), "",
           "sonar.transmit.frequency_hz: the number of values is 1, but there are 2 groups"},
          {with("sectors: [48, 48], frequency_hz: [9e5, 1.2e6]"), "",
           "sonar.transmit.frequency_hz: 1.2e+06 is more than a quarter away from"},
          {with("groups: 4, order: [0, 1, 2, 2]"), "",
           "sonar.transmit.order: this is no order of 4"},
          {with("groups: 4, order: [0, 1, 2]"), "", "expected each number from 0 to 3 once"},
          {with("groups: 4, level_db: [0, 1, 2]"), "",
           "sonar.transmit.level_db: the number of values is 3, but there are 4 groups"},
          {with("groups: 4, interval_s: -1"), "", "sonar.transmit.interval_s"},
          {chain_text("transmit: {groups: 4}, receiver: {mode: array}"), "",
           "sonar.transmit: the elements of an array"},
          {chain_text("electronics: {crosstalk_db: [-3, 5]}"), "", "crosstalk_db.1"},
          {chain_text("electronics: {crosstalk_db: []}"), "", "1 to 32 numbers"},
          {chain_text("electronics: {beam_gain_error_db: [1, 2, 3]}"), "", "beam_gain_error_db"},
      },
      [](const std::string& text) { return text; });
}

TEST_CASE("errors of beams and cross-talk leave no marks, so there is no mask") {
  const auto scenario =
      value_of(parse(chain_text("electronics: {beam_gain_error_db: 1, crosstalk_db: -20}")));
  CHECK_FALSE(scenario.output.selection.artifact);
}

// The resolved text has every key of a detector, and must be valid itself.
TEST_CASE("a detector without effects is read again") {
  read_again(value_of(parse(chain_text("detector: {}"))));
}

TEST_CASE("keys without effect and limits in the wrong order are errors") {
  testing::check_single_faults(
      {
          {chain_text("recorder: {db: [100, 60]}"), "", "expected [low, high] with low below high"},
          {chain_text("recorder: {db: [60, 100], gamma: 0.7}"), "", "expected scale: amplitude"},
          {chain_text("recorder: {}"), "", "db: missing"},
          {chain_text("receiver: {mode: array}",
                      "noise: {spectrum_level_db: 40, correlated: true}\n"),
           "", "sonar.receiver.mode: array"},
          {chain_text("electronics: {saturation: {streak_db: -3}}"), "", "level_db: missing"},
          {chain_text("electronics: {interference: {level_db: 100, ping_rate_hz: 10, "
                      "duration_s: 0.2}}"),
           "", "overlap"},
          {chain_text("recorder: {bits: 12, db: [60, 100]}"), "", "12 bits; expected 8 or 16"},
          {chain_text("detector: {law: amplitude}"), "", "expected it with integrate above 1"},
          {chain_text("range_max_m: 5, detector: {integrate: 300}"), "",
           "300 samples are more than the 200 of the record"},
          {chain_text("detector: {looks: 2}", "output: {statistics: true, pings: false}\n"), "",
           "has no effect on output.statistics"},
          {chain_text("detector: {looks: 0}"), "", "from 1 to 1000"},
      },
      [](const std::string& text) { return text; });
}

}  // namespace ensonify
