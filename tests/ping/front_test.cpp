// Front views against closed forms, in the frame of a sonar that is turned and stands elsewhere.
#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/front_planes.h"
#include "core/units.h"
#include "run_scene.h"
#include "trace/front.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr const char* kFrontScene = R"(ensonify: 1
name: front
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 8
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 60, azimuth: 2, min_per_cell: 0}
  elevation: {fan_deg: 20}
materials: {m: {reflectivity: 1e-3, law: {lambert: {exponent: 2}}}, dark: {reflectivity: 1e-12}}
output: {polar: false, cartesian: false, png: false, timeseries: none, front: true}
)";
// Level, 1 m north and 2 m above the origin, looking north.
constexpr const char* kTurned =
    "trajectory: {poses: [{position_m: [0, 1, 2], rotation_deg: [0, 0, 90]}]}\n";

// The view of ping 0, and the direction of each of its pixels.
struct Front {
  explicit Front(const std::string& rest)
      : run(SceneRun::of_text(std::string(kFrontScene) + rest)), view(*run.ping(0).front) {
    const Sonar& sonar = run.session().sonar;
    for (const double elevation : ray_elevations_rad(sonar)) {
      for (const double azimuth : ray_azimuths_rad(sonar)) {
        directions.push_back(unit_vector(azimuth, elevation));
      }
    }
    REQUIRE(view.rows == 60);
    REQUIRE(view.columns == 48);
    REQUIRE(directions.size() == view.range_m.size());
  }
  Vec3 normal(std::size_t i) const {
    return {view.normal_x[i], view.normal_y[i], view.normal_z[i]};
  }
  std::size_t at(int row, int column) const { return std::size_t(row) * view.columns + column; }

  SceneRun run;
  FrontView view;
  std::vector<Vec3> directions;
};

bool is_blank(const FrontView& view, std::size_t i) {
  return std::isnan(view.range_m[i]) && std::isnan(view.normal_x[i]) &&
         std::isnan(view.normal_y[i]) && std::isnan(view.normal_z[i]) &&
         std::isnan(view.backscatter_db[i]) && view.instance[i] == 0 && view.semantic[i] == 0;
}

}  // namespace

// Protects rows, columns, range, normal and level: a plane h = 1 m below the sonar is met at
// h/sin(-elevation), at an incidence with cosine sin(-elevation), and scatters mu cos^3. Rays
// upwards and those beyond the range limit meet nothing.
TEST_CASE("the front view of a plane below is h over the sine of the depression") {
  const Front front(std::string(kTurned) + R"(
objects:
  - {name: floor, class: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, 1]}}
)");
  int met = 0;
  for (std::size_t i = 0; i < front.directions.size(); ++i) {
    const double sine = -front.directions[i].z;
    if (sine <= 0 || 1 / sine > 8) {
      CHECK(is_blank(front.view, i));
      continue;
    }
    ++met;
    CHECK(front.view.range_m[i] == Approx(1 / sine).margin(kFrontRangeQuantum_m));
    CHECK(length(front.normal(i) - Vec3{0, 0, 1}) < 1e-3);
    CHECK(front.view.backscatter_db[i] ==
          Approx(10 * std::log10(1e-3 * sine * sine * sine)).margin(kFrontLevelQuantum_db));
    CHECK(front.view.instance[i] == 1);
    CHECK(front.view.semantic[i] == 1);
  }
  CHECK(met > 100);
  // Row 0 looks down the most.
  CHECK(is_blank(front.view, front.at(59, 0)));
  CHECK(front.view.range_m[front.at(0, 0)] < front.view.range_m[front.at(1, 0)]);
}

// Protects the frame: range and normal of a ball to starboard, by the quadratic equation of a ray.
TEST_CASE("the front view of a ball follows from the ray's equation") {
  const Vec3 center{4, -0.5, 0.2};  // in the sonar's frame
  const Front front(std::string(kTurned) + R"(
objects:
  - {name: other, class: other, material: m, shape: {sphere: {radius_m: 0.1}}, pose: {position_m: [0, -9, 0]}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.4}},
     pose: {position_m: [0.5, 5, 2.2]}}
)");
  int met = 0;
  for (std::size_t i = 0; i < front.directions.size(); ++i) {
    const Vec3 u = front.directions[i];
    const double along = dot(u, center);
    const double inside = along * along - dot(center, center) + 0.4 * 0.4;
    if (inside <= 0) {
      CHECK(is_blank(front.view, i));
      continue;
    }
    ++met;
    const double range = along - std::sqrt(inside);
    CHECK(front.view.range_m[i] == Approx(range).margin(kFrontRangeQuantum_m));
    const Vec3 normal = (1 / 0.4) * (range * u - center);
    CHECK(length(front.normal(i) - normal) < 1e-3);
    CHECK(front.view.instance[i] == 2);
    CHECK(front.view.semantic[i] == 2);
    const double grazing = -dot(u, normal);
    if (grazing < 0.2) continue;
    CHECK(front.view.backscatter_db[i] ==
          Approx(10 * std::log10(1e-3 * std::pow(grazing, 3))).margin(0.01));
  }
  CHECK(met > 200);
  CHECK(front.view.instance[front.at(34, 16)] == 2);  // columns rise to port
  CHECK(front.view.instance[front.at(34, 31)] == 0);
}

// Protects what is hidden: the larger box shows only around the smaller one before it.
TEST_CASE("a box behind another one is in the front view only beside it") {
  const Front front(std::string(kTurned) + R"(
objects:
  - {name: near, class: box, material: m, shape: {box: {size_m: [0.4, 1, 0.4]}}, pose: {position_m: [0, 4.5, 2]}}
  - {name: far, class: box, material: dark, shape: {box: {size_m: [1.2, 1, 1.2]}}, pose: {position_m: [0, 6.5, 2]}}
)");
  int near = 0, far = 0;
  for (std::size_t i = 0; i < front.directions.size(); ++i) {
    const Vec3 u = front.directions[i];
    const double side = std::max(std::abs(u.y), std::abs(u.z)) / u.x;
    const int expected = side < 0.2 / 3 ? 1 : side < 0.6 / 5 ? 2 : 0;
    CHECK(front.view.instance[i] == expected);
    if (expected == 0) continue;
    (expected == 1 ? near : far) += 1;
    CHECK(front.view.range_m[i] ==
          Approx((expected == 1 ? 3 : 5) / u.x).margin(kFrontRangeQuantum_m));
    CHECK(length(front.normal(i) - Vec3{-1, 0, 0}) < 1e-3);
    // Levels end at that of no energy.
    if (expected == 2) CHECK(front.view.backscatter_db[i] == kNoEnergyDb);
  }
  CHECK(near > 100);
  CHECK(far > 100);
}

// Protects refracted rays: in water whose speed falls with depth, the front view has the range that
// the time series shows, c times the one-way time, at the direction of departure.
TEST_CASE("the front view of refracted rays has the ranges of the echoes") {
  const std::string scene = std::string(kTurned) + R"(
objects:
  - {name: floor, class: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, 1]}}
)";
  const std::string text = std::string(kFrontScene) + scene + R"(
water:
  profile: {surface_z_m: 10, depth_m: [0, 20], sound_speed_m_s: [1560, 1420]}
)";
  const SceneRun run = SceneRun::of_text(text);
  const PingResult ping = run.ping(0);
  const FrontView& view = *ping.front;
  const Sonar& sonar = run.session().sonar;
  const double c = run.session().water.sound_speed_m_s;
  int met = 0;
  for (const Scatterer& s : ping.scatterers.items) {
    const auto ray = static_cast<int>(s.key);
    const int row = ray % sonar.rays_elevation, column = ray / sonar.rays_elevation;
    const std::size_t i = std::size_t(row) * view.columns + column;
    CHECK(view.range_m[i] == Approx(c * s.delay_s / 2).margin(kFrontRangeQuantum_m));
    CHECK(view.instance[i] == s.instance);
    ++met;
  }
  CHECK(met > 100);
  CHECK(met == static_cast<int>(std::ranges::count(view.instance, 1)));
  const Front straight(scene);
  CHECK(std::abs(view.range_m[0] - straight.view.range_m[0]) > 2 * kFrontRangeQuantum_m);
}

// Protects the rule of threads, and selections without front views.
TEST_CASE("front views do not depend on threads") {
  const std::string scene = std::string(kFrontScene) + kTurned + R"(
objects:
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.4}}, pose: {position_m: [0.2, 5, 2]}}
)";
  const SceneRun run = SceneRun::of_text(scene);
  const FrontView one = *run.ping(0, 1).front, three = *run.ping(0, 3).front;
  CHECK(one.instance == three.instance);
  for (std::size_t i = 0; i < one.range_m.size(); ++i) {
    CHECK((one.range_m[i] == three.range_m[i] ||
           (std::isnan(one.range_m[i]) && std::isnan(three.range_m[i]))));
  }
  std::string without = scene;
  without.replace(without.find("timeseries: none, front: true"), 29, "timeseries: npy");
  CHECK_FALSE(SceneRun::of_text(without).ping(0).front);
}
