#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;
using testing::read_again;

const std::string kBuoy =
    "materials: {m: {reflectivity: 1}}\nobjects:\n  - {name: a, material: m, "
    "shape: {sphere: {radius_m: 1}}, ";

// Protects the keys of each way: what must be given, and in which range.
TEST_CASE("lawnmowers and orbits are checked") {
  const std::string mow = "trajectory: {lawnmower: {corner_m: [0, 0, 0], length_m: 9, ";
  const std::string orbit = "trajectory: {orbit: {center_m: [0, 0, 0], radius_m: 4, ";
  check_single_faults({
      {mow + "width_m: 4, speed_m_s: 1}}", "4:25: trajectory.lawnmower.spacing_m:", "missing"},
      {mow + "width_m: 4, spacing_m: 0, speed_m_s: 1}}",
       "4:83: trajectory.lawnmower.spacing_m:", "a number > 0"},
      {mow + "width_m: -1, spacing_m: 1, speed_m_s: 1}}",
       "4:69: trajectory.lawnmower.width_m:", "from 0 to"},
      {mow + "width_m: 4, spacing_m: 1, speed_m_s: 0}}",
       "4:97: trajectory.lawnmower.speed_m_s:", "a number > 0"},
      {mow + "width_m: 4, spacing_m: 1, speed_m_s: 1, headng_deg: 3}}",
       "4:100: trajectory.lawnmower.headng_deg:", "did you mean heading_deg?"},
      {orbit + "speed_m_s: 1, turns: 0}}", "4:77: trajectory.orbit.turns:", "other than 0"},
      {orbit + "speed_m_s: 1, look: in}}",
       "4:76: trajectory.orbit.look:", "one of inward, outward, along"},
      {orbit + "turns: 1}}", "4:21: trajectory.orbit.speed_m_s:", "missing"},
      {orbit + "speed_m_s: 1}, poses: [{}]}", "4:71: trajectory:", "exclude each other"},
      {"trajectory: {orbit: 3}", "4:21: trajectory.orbit:", "a map with center_m"},
  });
}

// Protects objects that start with the first ping: the key is kept, and the sonar has none.
TEST_CASE("the path of an object may start with the first ping") {
  const std::string path = "spline: {points_m: [[0, 0, 0], [1, 0, 0]], speed_m_s: 1}";
  const auto late =
      value_of(parse(kHead + kBuoy + "trajectory: {" + path + ", from_first_ping: true}}\n"));
  CHECK(late.objects[0].trajectory->from_first_ping);
  CHECK(read_again(late).objects[0].trajectory->from_first_ping);
  const auto plain = value_of(parse(kHead + kBuoy + "trajectory: {" + path + "}}\n"));
  CHECK_FALSE(plain.objects[0].trajectory->from_first_ping);
  CHECK_FALSE(contains(emit(plain), "from_first_ping"));
  check_single_faults(
      {{"trajectory: {" + path + ", from_first_ping: true}", "4:89: trajectory.from_first_ping:",
        "expected in the trajectory of an "
        "object"}});
}

// Protects the spline's directions: they exist at every point.
TEST_CASE("splines are checked") {
  const std::string spline = "trajectory: {spline: {speed_m_s: 1, points_m: ";
  check_single_faults({
      {"trajectory: {spline: {speed_m_s: 1}}", "4:22: trajectory.spline.points_m:", "missing"},
      {spline + "[[0, 0, 0]]}}", "4:47: trajectory.spline.points_m:", "at least two points"},
      {spline + "[[0, 0, 0], [1, 0]]}}",
       "4:59: trajectory.spline.points_m.1:", "a list of 3 numbers"},
      {spline + "[[0, 0, 0], [1, 0, x]]}}",
       "4:66: trajectory.spline.points_m.1.2:", "`x` is not a number"},
      {spline + "[[0, 0, 0], [1, 0, 0], [1, 0, 0]]}}",
       "4:70: trajectory.spline.points_m.2:", "the point is at the place of the one before"},
      {spline + "[[0, 0, 0], [1, 0, 0], [-4, 0, 0]]}}",
       "4:59: trajectory.spline.points_m.1:", "doubles back"},
      {spline + "[[0, 0, 0], [1, 0, 0]], look: inward}}",
       "4:77: trajectory.spline.look:", "one of along, at_m"},
      {spline + "[[0, 0, 0], [1, 0, 0]], look: at_m}}",
       "4:77: trajectory.spline.look.at_m:", "missing"},
      {spline + "[[0, 0, 0], [1, 0, 0]], look: {at_m: [1]}}}",
       "4:84: trajectory.spline.look.at_m:", "a list of 3 numbers"},
  });
  CHECK(faults_of(kHead + spline + "[[0, 0, 0], [1, 0, 0], [-4, 0.1, 0]], look: along}}").empty());
}

TEST_CASE("wave motion is checked") {
  check_single_faults({
      {"trajectory: {wave_motion: {roll_deg: 1}}",
       "4:27: trajectory.wave_motion.period_s:", "missing"},
      {"trajectory: {wave_motion: {roll_deg: -1, period_s: 4}}",
       "4:38: trajectory.wave_motion.roll_deg:", "from 0 to 60"},
      {"trajectory: {wave_motion: {heave_m: 1, period_s: 0}}",
       "4:50: trajectory.wave_motion.period_s:", "a number > 0"},
      {"trajectory: {wave_motion: {period_s: 4, bandwidth: 0.5}}",
       "4:52: trajectory.wave_motion.bandwidth:", "from 0.01 to 0.33"},
      {"trajectory: {wave_motion: {period_s: 4, surge_m: 0.5}}",
       "4:41: trajectory.wave_motion.surge_m:",
       "expected one of roll_deg, pitch_deg, yaw_deg, heave_m"},
  });
}

// Protects objects with a trajectory: they have a way, no pose beside it, and send no pings.
TEST_CASE("trajectories of objects are checked") {
  const std::string orbit = "trajectory: {orbit: {center_m: [0, 0, 0], radius_m: 4, speed_m_s: 1}";
  const std::string at = "6:72: objects.0.trajectory";
  check_single_faults({
      {kBuoy + "trajectory: {}}", at + ":", "missing; expected one of poses, file, lawnmower"},
      {kBuoy + "trajectory: {wave_motion: {period_s: 1}}}", at + ":", "missing"},
      {kBuoy + orbit + ", pings: 4}}", "6:137: objects.0.trajectory.pings:", "has no effect on an"},
      {kBuoy + orbit + ", ping_rate_hz: 4}}",
       "6:144: objects.0.trajectory.ping_rate_hz:", "has no effect on an object"},
      {kBuoy + orbit + ", ping_rate: 4}}", "6:130: objects.0.trajectory.ping_rate:", "unknown key"},
      {kBuoy + orbit + "}, pose: {position_m: [0, 0, 0]}}",
       "6:137: objects.0.pose:", "has no effect with trajectory"},
      {kBuoy + "trajectory: 4}", at + ":", "a map with poses"},
      {kBuoy + "trajectory: {file: none.tum}}",
       "6:79: objects.0.trajectory.file:", "does not exist"},
  });
}

// Protects the identity of a data set: each way is written in full and reads back to itself.
TEST_CASE("the resolved text of ways reads back to itself") {
  const std::string waves =
      "wave_motion: {roll_deg: 1.5, pitch_deg: 0.25, yaw_deg: 3, heave_m: 0.1, period_s: 7.5, "
      "bandwidth: 0.3}";
  const std::vector<std::string> ways = {
      "lawnmower: {corner_m: [1, 2.5, -3], length_m: 30, width_m: 9.1, spacing_m: 1e-1, "
      "heading_deg: -33, speed_m_s: 1.5, start_time_s: 1700000000.125}",
      "orbit: {center_m: [1, 2.5, -3], radius_m: 1e-7, speed_m_s: 2, turns: -1.5, start_deg: 45, "
      "look: along, start_time_s: 3}",
      "orbit: {center_m: [1, 2.5, -3], radius_m: 4, speed_m_s: 2, look: outward}",
      "orbit: {center_m: [1, 2.5, -3], radius_m: 4, speed_m_s: 2}",
      "spline: {points_m: [[0, 0, 0], [1, 2.5, -1e-7], [3, 4, 5]], speed_m_s: 0.3}",
      "spline: {points_m: [[0, 0, 0], [1, 2.5, 0]], speed_m_s: 0.3, look: {at_m: [1, 2, 3]}, "
      "start_time_s: -5}",
      "poses: [{time_s: 3, position_m: [1, 2, 3]}, {time_s: 4, rotation_deg: [1, 2, 3]}]",
  };
  for (const std::string& way : ways) {
    for (const std::string& text :
         {"trajectory: {" + way + "}\n", "trajectory: {" + way + ", " + waves + ", pings: 3}\n",
          kBuoy + "trajectory: {" + way + "}}\n",
          kBuoy + "trajectory: {" + way + ", " + waves + "}}\n"}) {
      INFO(text);
      const auto first = value_of(parse(kHead + text));
      read_again(first);
    }
  }
}

// Protects against a resolved text that is stable but says something else.
TEST_CASE("the resolved text of ways keeps every value") {
  const auto first = value_of(parse(
      kHead + kBuoy +
      "trajectory: {spline: {points_m: [[0, 0, 0.5], [1, 2, 3]], speed_m_s: 0.3, look: {at_m: [4, "
      "5, 6]}, start_time_s: 8}, wave_motion: {roll_deg: 1, pitch_deg: 2, yaw_deg: 3, heave_m: 4, "
      "period_s: 5, bandwidth: 0.25}}}\n"
      "trajectory: {lawnmower: {corner_m: [1, 2, 3], length_m: 4, width_m: 5, spacing_m: 6, "
      "heading_deg: 7, speed_m_s: 8, start_time_s: 9}, ping_rate_hz: 10}\n"));
  const auto second = value_of(parse(emit(first)));
  for (const Scenario& s : {first, second}) {
    const auto& mow = std::get<LawnmowerSpec>(s.trajectory.path);
    CHECK(mow.corner_m == std::array<double, 3>{1, 2, 3});
    CHECK(mow.length_m == 4);
    CHECK(mow.width_m == 5);
    CHECK(mow.spacing_m == 6);
    CHECK(mow.heading_deg == 7);
    CHECK(mow.speed_m_s == 8);
    CHECK(mow.start_time_s == 9);
    CHECK_FALSE(s.trajectory.pings);
    CHECK_FALSE(s.trajectory.wave_motion);
    REQUIRE(s.objects[0].trajectory);
    const auto& spline = std::get<SplineSpec>(s.objects[0].trajectory->path);
    REQUIRE(spline.points_m.size() == 2);
    CHECK(spline.points_m[0][2] == 0.5);
    CHECK(spline.look_at_m == std::array<double, 3>{4, 5, 6});
    CHECK(spline.start_time_s == 8);
    REQUIRE(s.objects[0].trajectory->wave_motion);
    const WaveMotionSpec& waves = *s.objects[0].trajectory->wave_motion;
    CHECK(waves.roll_deg == 1);
    CHECK(waves.pitch_deg == 2);
    CHECK(waves.yaw_deg == 3);
    CHECK(waves.heave_m == 4);
    CHECK(waves.period_s == 5);
    CHECK(waves.bandwidth == 0.25);
  }
  const auto orbit =
      value_of(parse(kHead + "trajectory: {orbit: {center_m: [1, 2, 3], radius_m: 4, speed_m_s: 5, "
                             "turns: -6, start_deg: 7, look: outward}}\n"));
  const auto orbit_again = value_of(parse(emit(orbit)));
  const auto& way = std::get<OrbitSpec>(orbit_again.trajectory.path);
  CHECK(way.center_m == std::array<double, 3>{1, 2, 3});
  CHECK(way.radius_m == 4);
  CHECK(way.speed_m_s == 5);
  CHECK(way.turns == -6);
  CHECK(way.start_deg == 7);
  CHECK(way.look == OrbitLook::outward);
}

// Protects assets: the paths of objects travel with the data set, each once.
TEST_CASE("path files of objects are input files") {
  const test::TemporaryFolder folder;
  folder.write("b.tum", "0 0 0 0 0 0 0 1\n");
  folder.write("c.csv", "x\n");
  const auto scenario = value_of(
      parse_scenario(kHead + kBuoy + "trajectory: {file: b.tum}}\ntrajectory: {file: c.csv}\n",
                     "t.yaml", folder.path()));
  CHECK(input_files(scenario) == std::vector{folder.path() / "b.tum", folder.path() / "c.csv"});
}

}  // namespace
}  // namespace ensonify
