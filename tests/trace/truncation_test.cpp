#include "trace/truncation.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

// 90 by 20 degrees, 1 to 10 m.
Sonar quarter_sonar() {
  Sonar sonar;
  sonar.beam_count = 90;
  sonar.beam_spacing_rad = radians(1);
  sonar.elevation_fan_rad = radians(20);
  sonar.range_min_m = 1;
  sonar.range_max_m = 10;
  return sonar;
}

double truncated(const Shape& shape, Vec3 at_m, const Sonar& sonar = quarter_sonar()) {
  return truncated_share(surface_samples(shape), {at_m, {}}, {}, sonar);
}

constexpr double kLattice = 0.006;  // how evenly 1000 points lie

Shape corner_of_a_cube() {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return MeshShape{mesh};
}

}  // namespace

// Protects every limit: a plane through the middle of a ball halves its surface, and each limit of
// the fan is one to a small ball.
TEST_CASE("a ball with its middle on a limit is half truncated") {
  const Shape ball = SphereShape{0.1};
  CHECK(truncated(ball, {5, 0, 0}) == 0);
  const double azimuth = radians(45), elevation = radians(10);
  CHECK(truncated(ball, 5 * Vec3{std::cos(azimuth), std::sin(azimuth), 0}) ==
        Approx(0.5).margin(kLattice));
  CHECK(truncated(ball, 5 * Vec3{std::cos(azimuth), -std::sin(azimuth), 0}) ==
        Approx(0.5).margin(kLattice));
  CHECK(truncated(ball, 5 * Vec3{std::cos(elevation), 0, std::sin(elevation)}) ==
        Approx(0.5).margin(kLattice));
  CHECK(truncated(ball, {-5, 0, 0}) == 1);
}

// The sphere of radius R around the sonar cuts a ball of radius r at distance d at the height
// h = (d^2 + r^2 - R^2) / 2d before its middle, and its area beyond is (r + h) / 2r of all.
TEST_CASE("range limits cut a ball by the closed form") {
  for (const double radius : {0.1, 0.5}) {
    for (const double distance : {9.8, 10.0, 10.2}) {
      const double h = (distance * distance + radius * radius - 100) / (2 * distance);
      const double beyond = std::clamp((radius + h) / (2 * radius), 0.0, 1.0);
      INFO("radius " << radius << ", distance " << distance);
      CHECK(truncated(SphereShape{radius}, {distance, 0, 0}) == Approx(beyond).margin(kLattice));
    }
  }
  CHECK(truncated(SphereShape{0.02}, {1, 0, 0}) == Approx(0.5).margin(0.01));
}

// Protects the weights by area. Above the fan lies what is over z = x tan 10 degrees. A flat box of
// 0.02 x 0.02 x 1 m has nearly all its area on its sides: 0.3 of its height above are 0.3 of it.
TEST_CASE("area counts, not faces") {
  const Shape post = BoxShape{{0.01, 0.01, 0.5}};
  const double top = 5 * std::tan(radians(10));
  CHECK(truncated(post, {5, 0, top - 0.2}) == Approx(0.3).margin(0.01));
  const Shape rod = CylinderShape{0.01, 0.5};
  CHECK(truncated(rod, {5, 0, top - 0.2}) == Approx(0.3).margin(0.01));
}

// Protects meshes: the slanted face of a corner_of_a_cube has sqrt(3) / (3 + sqrt(3)) of its area.
TEST_CASE("points lie on a mesh by the area of its triangles") {
  const std::vector<Vec3> points = surface_samples(corner_of_a_cube());
  REQUIRE(points.size() == kSurfaceSamples);
  int slanted = 0;
  for (const Vec3 p : points) {
    slanted += std::abs(p.x + p.y + p.z - 1) < 1e-6;
    const double nearest = std::min({p.x, p.y, p.z, 1 - p.x - p.y - p.z});
    CHECK(std::abs(nearest) < 1e-6);
  }
  CHECK(slanted == Approx(1000 * std::sqrt(3) / (3 + std::sqrt(3))).margin(1));
}

// Protects poses: the share is that of the sonar's frame.
TEST_CASE("truncation turns with the sonar") {
  const std::vector<Vec3> points = surface_samples(SphereShape{0.1});
  const Pose turned{{1, 2, 3}, from_roll_pitch_yaw(0, 0, radians(90))};
  CHECK(truncated_share(points, {{1, 7, 3}, {}}, turned, quarter_sonar()) == 0);
  CHECK(truncated_share(points, {{6, 2, 3}, {}}, turned, quarter_sonar()) == 1);
}

TEST_CASE("a plane has no truncated share") {
  CHECK(surface_samples(PlaneShape{}).empty());
  CHECK(std::isnan(truncated(PlaneShape{}, {5, 0, 0})));
}
