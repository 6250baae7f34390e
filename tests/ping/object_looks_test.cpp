// What `check` tells of each object before anything is made.
#include "ping/object_looks.h"
#include "ping/prepare_session.h"

#include <cmath>
#include <string>

#include "catch.h"
#include "core/units.h"
#include "results.h"
#include "run/make_dataset.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

std::string scene(const std::string& ball_position, double reflectivity,
                  const std::string& mount = "[0, 20, 0]") {
  return "ensonify: 1\nname: looks\nsonar:\n  preset: paper_table1\n  bandwidth_hz: 29900\n"
         "  range_max_m: 6\n  beams: "
         "{count: 48, fov_deg: 48, shading: {taylor: {side_lobe_db: -40}}}\n  elevation: {width_deg: 20}\n  rays: {elevation: 60}\n  mount: "
         "{rotation_deg: " +
         mount + "}\nmaterials: {sand: {reflectivity: 1e-3}, m: {reflectivity: " +
         std::to_string(reflectivity) +
         "}}\nobjects:\n  - {name: floor, class: floor, material: sand, shape: {plane: {}}, pose: "
         "{position_m: [0, 0, -1.5]}}\n  - {name: ball, class: ball, material: m, shape: {sphere: "
         "{radius_m: 0.25}}, pose: {position_m: " +
         ball_position + "}}\nnoise: {spectrum_level_db: 40}\n";
}

struct Looked {
  std::vector<ObjectLook> looks;
  std::vector<std::string> warnings;
};

Looked looked(const std::string& text) {
  const Session session = prepared(text);
  const Tracer tracer(session.world);
  const auto numerics = value_of(settled_numerics(BackendChoice::cpu, best_simd_level(), true));
  const Workers workers(2);
  const auto looks = value_of(look_at_objects(session, tracer, 0, numerics, workers));
  SeenObjects seen;
  note_seen(session, tracer, 0, looks, workers, seen);
  return {looks, unseen_warnings(seen, session.scenario)};
}

}  // namespace

// Protects the first thing that a user reads of a scene: where things are, in the sonar's frame.
TEST_CASE("an object in view is told with its place, size and level") {
  const Looked told = looked(scene("[3, 1, -1.25]", 0.01));
  REQUIRE(told.looks.size() == 2);
  const ObjectLook& ball = told.looks[1];
  CHECK(ball.name == "ball");
  CHECK(std::abs(ball.range_m - std::sqrt(9 + 1 + 1.25 * 1.25)) < 1e-12);
  // Nose down by 20 degrees: x and z of the sonar turn about y.
  const double c = std::cos(radians(20)), s = std::sin(radians(20));
  const double x = 3 * c + 1.25 * s, z = 3 * s - 1.25 * c;
  CHECK(std::abs(ball.azimuth_rad - std::atan2(1, x)) < 1e-12);
  CHECK(std::abs(ball.elevation_rad - std::atan2(z, std::hypot(x, 1))) < 1e-12);
  CHECK(ball.size_m->x == 0.5);
  CHECK(ball.share_in_fan == 1);
  CHECK(ball.pixels > 5);
  CHECK_FALSE(told.looks[0].size_m.has_value());
  CHECK_FALSE(told.looks[0].share_in_fan.has_value());
  CHECK(told.warnings.empty());
  const auto lines = look_lines(told.looks);
  REQUIRE(lines.size() == 3);
  CHECK_FALSE(contains(lines[1], "%"));
  CHECK(contains(lines[2], "0.5 x 0.5 x 0.5"));
  CHECK(contains(lines[2], " 100 %"));
  ObjectLook other = ball;
  other.share_in_fan = 1e-4;
  CHECK(contains(look_lines({other})[1], " <1 %"));
  other.share_in_fan = 0;
  CHECK(contains(look_lines({other})[1], " 0 %"));
}

// Protects the levels: ten times the reflectivity of the ball is 10 dB over the noise, but for what
// its pixels share with the floor, and less over the ground, to which its side lobes add. The ground is
// not told over itself.
TEST_CASE("levels over ground and noise follow the object's own") {
  const auto of = [](double reflectivity) { return looked(scene("[3, 0, -1.25]", reflectivity)).looks; };
  const auto weak = of(0.01), strong = of(0.1);
  CHECK(std::abs(*strong[1].over_noise_db - *weak[1].over_noise_db - 10) < 1);
  const double gained_db = *strong[1].over_ground_db - *weak[1].over_ground_db;
  CHECK(gained_db > 3);
  CHECK(gained_db < 10);
  CHECK(*weak[1].over_ground_db > 3);
  CHECK_FALSE(weak[0].over_ground_db.has_value());
  CHECK(weak[0].over_noise_db.has_value());
}

// Protects from silent nothing: behind the sonar, and a pitch in radians.
TEST_CASE("what no ray meets is told") {
  const Looked behind = looked(scene("[-3, 0, -1.25]", 0.01));
  REQUIRE(behind.warnings.size() == 1);
  CHECK(behind.warnings[0].find("ball is never in view: at ping 0 it is at range 3.25 m, azimuth 180 "
                                "deg") == 0);
  CHECK(behind.looks[1].share_in_fan == 0);
  CHECK(behind.looks[1].pixels == 0);
  const Looked level = looked(scene("[3, 0, -1.25]", 0.01, "[0, 0.35, 0]"));
  REQUIRE(level.warnings.size() == 3);
  CHECK(level.warnings[0] ==
        "ping 0 of sequence 0: no ray of the fan hits anything in range; "
        "sonar.mount.rotation_deg is in degrees");
}

// Protects `check` from tracing a scene at rest again and again, and from missing what moves.
TEST_CASE("pings are distinct where the sonar or an object moves") {
  using Pings = std::vector<std::uint32_t>;
  const std::string text = scene("[3, 0, -1.25]", 0.01);
  const std::string rest = "trajectory: {ping_rate_hz: 1, pings: 5}\n";
  const std::string moving =
      "trajectory: {ping_rate_hz: 1, pings: 5, poses: [{time_s: 0, position_m: [0, 0, 0]}, "
      "{time_s: 4, position_m: [1, 0, 0]}]}\n";
  CHECK(distinct_pings(prepared(text)) == Pings{0});
  CHECK(distinct_pings(prepared(text + rest)) == Pings{0});
  CHECK(distinct_pings(prepared(text + moving)) == Pings{0, 2, 4});
}
