// Shadows, amodal masks and occlusion of whole pings, against closed forms.
#include <cmath>
#include <string>

#include "catch.h"
#include "core/units.h"
#include "labels/cartesian.h"
#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Seen {
  Session session;
  SequenceInfo info;
  PingResult ping;

  const Annotation* find(const std::string& name, const std::vector<Annotation>& list) const {
    for (const Annotation& annotation : list) {
      if (info.instances[annotation.instance - 1u].name == name) return &annotation;
    }
    return nullptr;
  }
};

Seen look(const std::string& objects, const std::string& sonar = "", const std::string& more = "") {
  const std::string text = R"(ensonify: 1
name: hidden
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 9
)" + sonar + R"(materials: {m: {reflectivity: 1e-3}}
objects:
)" + objects + more;
  Seen seen{prepared(text), {}, {}};
  const Tracer tracer(seen.session.world);
  seen.info = sequence_info(seen.session, 0, 0, 1);
  seen.ping = pipeline_of(seen.session, tracer, seen.info).run(0, Workers(2));
  return seen;
}

constexpr const char* kLevelSonar = R"(  beams: {count: 32, fov_deg: 30}
  rays: {elevation: 60, azimuth: 2}
)";

constexpr const char* kBallScene =
    "  - {name: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [6, 0, "
    "0]}}\n";

std::string wall(double y_m) {
  return "  - {name: wall, material: m, shape: {box: {size_m: [0.1, 4, 4]}}, pose: {position_m: "
         "[3, " +
         std::to_string(y_m) + ", 0]}}\n";
}

}  // namespace

// Protects the place of a shadow and its occluder: on the middle beam the floor is in shadow between
// the rays that touch the ball below and above, at slant ranges h / sin(depression). Rays of 0.033
// degrees are 0.012 m apart there, a sample is 0.025 m. And the Cartesian shadow is the polar one
// through the map, pixel by pixel.
TEST_CASE("a ball's shadow on the floor lies between its tangents") {
  const Seen seen = look(R"(  - {name: floor, material: m, shape: {plane: {}}}
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.4}}, pose: {position_m: [4, 0, 1]}}
)",
                         R"(  beams: {count: 17, fov_deg: 12}
  rays: {elevation: 1200}
  elevation: {fan_deg: 40}
  mount: {position_m: [0, 0, 3], rotation_deg: [0, 26, 0]}
)");
  const double middle = std::atan2(2, 4), half = std::asin(0.4 / std::hypot(2, 4));
  const double start_m = 3 / std::sin(middle + half), end_m = 3 / std::sin(middle - half);
  const double step_m = sample_range_m(seen.session.sonar, seen.session.water, 1);
  const LabelledImage& polar = *seen.ping.polar;
  for (int n = 0; n < polar.rows; ++n) {
    const double range_m = n * step_m;
    if (std::min(std::abs(range_m - start_m), std::abs(range_m - end_m)) < 2.5 * step_m) continue;
    INFO("range " << range_m);
    CHECK(polar.shadow[std::size_t(n) * 17 + 8] == (range_m > start_m && range_m < end_m ? 2 : 0));
  }
  const auto map = cartesian_map(*seen.info.cartesian, seen.session.sonar, seen.session.water,
                                 seen.session.record);
  std::size_t shadows = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    REQUIRE(seen.ping.cartesian->shadow[i] == (map[i] < 0 ? 0 : polar.shadow[map[i]]));
    shadows += seen.ping.cartesian->shadow[i] == 2;
  }
  CHECK(shadows > 100);
  // The floor's amodal mask goes on under the shadow.
  const Annotation* floor = seen.find("floor", seen.ping.polar_annotations);
  REQUIRE(floor != nullptr);
  CHECK(floor->amodal->area > floor->area + 50);
  CHECK(seen.find("ball", seen.ping.polar_annotations)->occlusion == 0);
}

// Protects "were everything else transparent": behind a wall a ball's amodal mask is, run for run,
// its visible mask without the wall; it is seen nowhere, and is wholly hidden.
TEST_CASE("behind a wall a ball's amodal mask is what it is without the wall") {
  const Seen behind = look(kBallScene + wall(0), kLevelSonar), free = look(kBallScene, kLevelSonar);
  const auto compare = [&](const std::vector<Annotation>& hidden_list,
                           const std::vector<Annotation>& seen_list,
                           const std::vector<Annotation>& annotations) {
    const Annotation* hidden = behind.find("ball", hidden_list);
    const Annotation* seen = free.find("ball", seen_list);
    REQUIRE(hidden != nullptr);
    REQUIRE(seen != nullptr);
    CHECK(behind.find("ball", annotations) == nullptr);
    CHECK(hidden->amodal->rle_counts == seen->rle_counts);
    CHECK(hidden->amodal->box == seen->box);
    CHECK(hidden->amodal->area == seen->area);
    CHECK(seen->amodal->rle_counts == seen->rle_counts);
    CHECK(hidden->occlusion == 1);
    CHECK(seen->occlusion == 0);
    CHECK(behind.find("wall", annotations)->occlusion == 0);
  };
  compare(behind.ping.polar_hidden, free.ping.polar_annotations, behind.ping.polar_annotations);
  compare(behind.ping.cartesian_hidden, free.ping.cartesian_annotations,
          behind.ping.cartesian_annotations);
  CHECK(free.ping.polar_hidden.empty());
  // Where the ball would be heard the wall casts its shadow.
  const Annotation& ball = *free.find("ball", free.ping.polar_annotations);
  std::int64_t shadows = 0;
  for (const std::uint16_t id : behind.ping.polar->shadow) shadows += id == 2;
  CHECK(shadows == ball.area);
}

// Protects the share of rays: a wall whose edge runs through the boresight hides one of two
// symmetric halves.
TEST_CASE("a wall before half of a ball hides half of its rays") {
  const Seen seen = look(kBallScene + wall(2), kLevelSonar);
  const Annotation* ball = seen.find("ball", seen.ping.polar_annotations);
  REQUIRE(ball != nullptr);
  CHECK(ball->occlusion == 0.5);
  CHECK(ball->area == Approx(ball->amodal->area / 2.0).epsilon(0.05));
}

// Protects point targets: one behind a wall counts as hidden, and is in the wall's shadow; behind
// two walls it is in the shadow of neither alone.
TEST_CASE("a point target behind a wall is hidden and in its shadow") {
  const std::string target =
      "point_targets:\n  - {name: target, target_strength_db: -20, position_m: [6, 0.05, 0]}\n";
  const Seen one = look(wall(0), kLevelSonar, target);
  REQUIRE(one.find("target", one.ping.polar_hidden) != nullptr);
  CHECK(one.find("target", one.ping.polar_hidden)->occlusion == 1);
  CHECK(one.find("target", one.ping.polar_annotations) == nullptr);
  std::int64_t shadows = 0;
  for (const std::uint16_t id : one.ping.polar->shadow) shadows += id == 1;
  CHECK(shadows == one.find("target", one.ping.polar_hidden)->amodal->area);
  const std::string second =
      "  - {name: other, material: m, shape: {box: {size_m: [0.1, 4, 4]}}, pose: {position_m: [4, "
      "0, 0]}}\n";
  const Seen two = look(wall(0) + second, kLevelSonar, target);
  const double step_m = sample_range_m(two.session.sonar, two.session.water, 1);
  for (int n = static_cast<int>(5.5 / step_m); n < two.ping.polar->rows; ++n) {
    for (int j = 0; j < 32; ++j) {
      REQUIRE(two.ping.polar->shadow[static_cast<std::size_t>(n) * 32 + j] == 0);
    }
  }
  CHECK(two.find("target", two.ping.polar_hidden) != nullptr);
}

// Protects what is switched off: no masks, no shadows, and everything else as it was.
TEST_CASE("without shadow and amodal a ping is as it was") {
  const Seen on = look(kBallScene + wall(2), kLevelSonar);
  const Seen off =
      look(kBallScene + wall(2), kLevelSonar, "output: {shadow: false, amodal: false}\n");
  CHECK(off.ping.polar->shadow.empty());
  CHECK(off.ping.cartesian->shadow.empty());
  CHECK_FALSE(off.ping.polar_annotations[0].amodal);
  CHECK(off.ping.polar_hidden.empty());
  CHECK(off.ping.series == on.ping.series);
  CHECK(off.ping.polar->instance == on.ping.polar->instance);
  CHECK(off.ping.polar_annotations[0].rle_counts == on.ping.polar_annotations[0].rle_counts);
}

namespace {

// A wall across the view on a floor 2 m below the sonar: its far edge is 4.1 m away, its top 0.6 m
// high.
constexpr const char* kWall = R"(ensonify: 1
name: shadow
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 9
  beams: {count: 65, fov_deg: 32.5}
  rays: {elevation: 1200}
  elevation: {fan_deg: 50}
  mount: {rotation_deg: [0, 25, 0]}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: floor, class: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: wall, class: wall, material: m, shape: {box: {size_m: [0.2, 8, 0.6]}}, pose: {position_m: [4, 0, -1.7]}}
)";

}  // namespace

// Protects what lies behind an object: on the middle beam no floor is heard from the wall's front
// to where the ray over its far edge meets the floor, h d / (h - a) = 5.857 m away on the ground;
// rays of 0.04 degrees there are 0.02 m apart, a sample is 0.025 m.
TEST_CASE("the shadow of a wall ends where the ray over its edge meets the floor") {
  const SceneRun run = SceneRun::of_text(kWall);
  const PingResult ping = run.ping(0);
  REQUIRE(ping.polar.has_value());

  const double step_m = sample_range_m(run.session().sonar, run.session().water, 1);
  const double height_m = 2, top_m = 0.6, far_edge_m = 4.1;
  const double ground_m = height_m * far_edge_m / (height_m - top_m);
  const double end_m = std::hypot(ground_m, height_m);
  const double front_m = std::hypot(3.9, height_m - top_m);  // the wall's nearest: its front's top
  const std::uint16_t floor = 1;
  double last_before = 0, first_behind = 0;
  for (int row = 0; row < ping.polar->rows; ++row) {
    if (ping.polar->instance[static_cast<std::size_t>(row) * 65 + 32] != floor) continue;
    const double range_m = row * step_m;
    if (range_m < end_m - 0.3) last_before = range_m;
    if (range_m > end_m - 0.3 && first_behind == 0) first_behind = range_m;
  }
  // In front of the wall the floor is heard up to its foot, which lies beyond the wall's top.
  CHECK(last_before > front_m - 2 * step_m);
  CHECK(last_before < std::hypot(3.9, height_m) + 2 * step_m);
  CHECK(first_behind == Approx(end_m).margin(2 * step_m));
}
