// Shadows against closed forms.
#include <cmath>

#include "catch.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// A wall across the view on a floor 2 m below the sonar: its far edge is 4.1 m away, its top 0.6 m
// high.
constexpr const char* kWall = R"(ensonify: 1
name: shadow
sonar:
  preset: blueview_p900_90
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
