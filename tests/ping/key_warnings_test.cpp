// Keys that imply one quantity and disagree, and what a fan leaves out.
#include "ping/key_warnings.h"

#include <string>

#include "catch.h"
#include "is_refused.h"
#include "results.h"
#include "run_scene.h"
#include "scenario/scenario.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

std::string key_scene(const std::string& rest, const std::string& sonar = "") {
  return "ensonify: 1\nname: scene\nsonar: {preset: blueview_p900_90, range_max_m: 15, beams: "
         "{count: 8, fov_deg: 8}, rays: {elevation: 16}" +
         sonar + "}\n" + rest;
}

std::vector<std::string> told_of(const std::string& rest, const std::string& sonar = "") {
  INFO(rest);
  return key_warnings(prepared(key_scene(rest, sonar)));
}

// The only warning, or a text that no warning has.
std::string only_one(const std::vector<std::string>& told) {
  return told.size() == 1 ? told[0] : "number of warnings: " + std::to_string(told.size());
}

constexpr const char* kSteelBall =
    "objects: [{name: ball, class: ball, material: steel_smooth, shape: {sphere: {radius_m: 0.2}}, "
    "pose: {position_m: [8, 0, 0]}}]\n";

}  // namespace

// Protects levels and ranges: two waters in one scenario are told, one is not.
TEST_CASE("water that contradicts itself is told") {
  CHECK(told_of("").empty());
  CHECK(told_of("water: {temperature_c: 20, salinity_psu: 0}\n").empty());
  CHECK(told_of("water: {sound_speed_m_s: 1480}\n").empty());
  CHECK(told_of("water: {sound_speed_m_s: 1400, absorption: {fixed_db_m: 0.1}}\n").empty());
  CHECK(only_one(told_of("water: {sound_speed_m_s: 1400}\n"))
            .starts_with("water.sound_speed_m_s: 1400 is not the 1489.8 of the water whose "
                         "absorption is used (10 °C and 35 psu)"));
  CHECK(only_one(told_of("water: {sound_speed_m_s: {from: {temperature_c: 20, salinity_psu: 0, "
                         "depth_m: 0}}, absorption: {model: ainslie_mccolm, temperature_c: 10, "
                         "salinity_psu: 35}}\n"))
            .starts_with("water.absorption: 10 °C and 35 psu are not the 20 °C and 0 psu of the "
                         "water described"));
}

// Protects echoes of walls and elastic bodies, which alone hear the density.
TEST_CASE("a density that is not that of the water is told where it matters") {
  const std::string fresh =
      "water: {sound_speed_m_s: {from: {temperature_c: 20, salinity_psu: 0, depth_m: 2}}";
  const std::string ball =
      "point_targets: [{name: b, sphere: {radius_m: 0.02, material: copper}, position_m: [5, 0, "
      "0]}]\n";
  CHECK(told_of(fresh + "}\n" + kSteelBall).empty());
  CHECK(
      only_one(told_of(fresh + "}\n" + ball))
          .starts_with("water.density_kg_m3: 1025 is not the 998.22 of the water described (20 °C "
                       "and 0 psu)"));
  CHECK(told_of(fresh + ", density_kg_m3: 999}\n" + ball).empty());
  CHECK(told_of("water: {temperature_c: 20, salinity_psu: 0}\n" + ball).empty());
}

TEST_CASE("a sound speed outside the profile is told") {
  const std::string profile =
      "profile: {depth_m: [0, 50], sound_speed_m_s: [1450, 1460]}, absorption: {fixed_db_m: 0}}\n";
  CHECK(told_of("water: {sound_speed_m_s: 1458, " + profile).empty());
  CHECK(contains(only_one(told_of("water: {" + profile)),
                 "assumes 1500, but the profile has 1450 to 1460, so ranges are wrong by 2.7 %"));
}

// Protects levels: a beam far narrower than its cell hears all of the cell.
TEST_CASE("beams much narrower than their cells are told") {
  CHECK(told_of("", ", elevation: {width_deg: 20}").empty());
  const auto told = key_warnings(prepared(key_scene(""), {{"sonar.beams.fov_deg", "24"}}));
  CHECK(contains(only_one(told),
                 "is 3 degrees wide and its beam 1, but it receives the echo of the "
                 "whole cell, up to 4.8 dB more"));
}

// Protects widths: those of an array follow from its elements.
TEST_CASE("a beam width that is not that of the array is told") {
  const std::string array = ", receiver: {mode: array, elements: ";
  // 0.884 lambda / (n lambda / 2): 101 elements have 1 degree.
  CHECK(told_of("", array + "101}").empty());
  CHECK(contains(only_one(told_of("", array + "60}")),
                 "receive_width_deg: 1 is not the 1.69 of 60 elements 0.000833 m apart"));
}

TEST_CASE("a seabed that is not the bottom of multipath is told") {
  const auto bottom_at = [](const std::string& z_m) {
    return told_of(
        "objects: [{name: bed, material: sand_fine, shape: {plane: {}}, pose: "
        "{position_m: [0, 0, -3]}}]\nmultipath: {bottom: {z_m: " +
        z_m + ", reflection: 0.3}}\n");
  };
  CHECK(bottom_at("-3").empty());
  CHECK(contains(only_one(bottom_at("-3.5")), "-3.5 is not the height -3 of bed"));
}

// Protects from rates that no sonar has: the next ping is sent when the last echo has arrived.
TEST_CASE("pings that overlap are told, and refused where everything moves") {
  const std::string at = "trajectory: {pings: 3, ping_rate_hz: ";
  CHECK(told_of(at + "50}\n").empty());  // exactly 2 x 15 m / 1500 m/s
  CHECK(only_one(told_of(at + "50.1}\n")) ==
        "trajectory.ping_rate_hz: 50.1 Hz sends a ping every 0.02 s, but echoes from 15 m "
        "(sonar.range_max_m) take 0.02 s; expected at most 50 Hz, or a shorter range");
  CHECK(told_of("trajectory: {pings: 1, ping_rate_hz: 500}\n").empty());
  CHECK(told_of(at + "500}\noutput: {statistics: true, pings: false}\n").empty());
  const auto moving = [&](const std::string& rate) {
    return prepare_session(
        value_of(parse_scenario(key_scene(at + rate + "}\nmotion_within_ping: true\n"), "t", ".")),
        0);
  };
  CHECK(moving("50").ok());
  CHECK(is_refused(moving("60"),
                   "expected at most 50 Hz, or a shorter range, or "
                   "motion_within_ping: false",
                   ErrorKind::usage));
}

// Protects from bodies that rest unnoticed: times of the epoch next to relative ones.
TEST_CASE("paths that end before the first ping are told and can start with it") {
  const auto told = [](const std::string& keys) {
    return prepared(key_scene(
        "objects: [{name: diver, material: steel_smooth, shape: {sphere: {radius_m: 0.2}}, "
        "trajectory: {spline: {points_m: [[9, -2, 0], [9, 0, 0], [9, 2, 0]], speed_m_s: 1}" +
        keys +
        "}}]\ntrajectory: {poses: [{time_s: 1.6e9, position_m: [0, 0, 0]}, {time_s: 1600000004, "
        "position_m: [0, 0, 0]}]}\n"));
  };
  CHECK(only_one(key_warnings(told("")))
            .starts_with("objects.diver.trajectory: the path lasts from 0 to 4 s, but the pings "
                         "are at 1600000000 "
                         "to 1600000004 s, so the object rests"));
  const Session first = told(", from_first_ping: true");
  CHECK(key_warnings(first).empty());
  CHECK(object_poses(first, 0)[0].position_m.y == Approx(-2));
  CHECK(object_poses(first, 2)[0].position_m.y == Approx(0).margin(1e-6));
}

// Protects the near seabed: what lies beyond the fan is named, with the fan that has it.
TEST_CASE("a fan that leaves out what the pattern hears is told") {
  const std::string bed =
      "objects: [{name: bed, class: bed, material: sand_fine, shape: {plane: {}}, pose: "
      "{position_m: [0, 0, -3]}}]\ntrajectory: {poses: [{position_m: [0, 0, 0], rotation_deg: [0, "
      "15, 0]}]}\n";
  const auto told = [&](const std::string& elevation) {
    const Session session = prepared(key_scene(bed, ", elevation: {" + elevation + "}"));
    return fan_warnings(session, Tracer(session.world), Workers(1));
  };
  CHECK(told("width_deg: 20").empty());
  CHECK(told("width_deg: 20, fan_deg: 50").empty());
  // The bed begins at 3 / sin(15 + 16.9 degrees) = 5.68 m, and the pattern is above -20 dB to 4.8
  // m.
  const std::string text = only_one(told("width_deg: 20, fan_deg: 33.8"));
  INFO(text);
  CHECK(
      text.starts_with("sonar.elevation.fan_deg: the fan ends at 16.9 degrees of elevation, but "
                       "the pattern of width_deg 20 has up to -9"));
  CHECK(contains(text, "leaves out at ping 0 bed from 4.82 to 5.66 m"));
  // The fan that it names leaves out nothing.
  const std::string fan = text.substr(text.rfind("fan_deg: ") + 9);
  CHECK(told("width_deg: 20, fan_deg: " + fan.substr(0, fan.find(' '))).empty());
  // Side lobes of -13 dB count, too.
  CHECK(contains(only_one(told("width_deg: 20, shading: uniform, fan_deg: 45")), "up to -13 dB"));
}
