#include "world/shapes.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"

using namespace ensonify;

namespace {

// A ray from a random place outside a ball of radius 4 towards a random place in one of radius 1.5.
Ray random_ray(std::uint64_t i) {
  const auto draw = [&](std::uint32_t d) { return 2 * uniform(4, 0, i, d) - 1; };
  const Vec3 from = 4.0 * normalized(Vec3{draw(0), draw(1), draw(2)});
  const Vec3 to = 1.5 * Vec3{draw(3), draw(4), draw(5)};
  return {from, normalized(to - from)};
}

// The first sign change of `inside` along a ray, by small steps and bisection: a route that shares
// nothing with the closed forms.
template <class Inside>
double marched(const Ray& ray, Inside inside) {
  const double step = 1e-3;
  const auto at = [&](double t) { return inside(ray.origin_m + t * ray.direction); };
  for (double t = 0; t < 10; t += step) {
    if (at(t) == at(t + step)) continue;
    double low = t, high = t + step;
    for (int i = 0; i < 50; ++i) {
      const double middle = (low + high) / 2;
      (at(middle) == at(t) ? low : high) = middle;
    }
    return low;
  }
  return INFINITY;
}

template <class Shape, class Inside>
void compare_with_marching(const Shape& shape, Inside inside) {
  int hits = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Ray ray = random_ray(i);
    const auto hit = intersect(shape, ray, 1e-6);
    const double expected = marched(ray, inside);
    // A chord shorter than the marcher's step is beyond it.
    if (hit && std::isinf(expected)) continue;
    REQUIRE(hit.has_value() == std::isfinite(expected));
    if (!hit) continue;
    ++hits;
    CHECK(hit->range_m == Approx(expected).margin(1e-9));
    CHECK(length(hit->normal) == Approx(1));
    CHECK(dot(hit->normal, ray.direction) < 1e-9);  // from outside: against the ray
  }
  CHECK(hits > 50);
}

}  // namespace

TEST_CASE("box, sphere and cylinder agree with marching along the ray") {
  const BoxShape box{{0.5, 1.0, 0.7}, false};
  compare_with_marching(box, [&](Vec3 p) {
    return std::abs(p.x) < 0.5 && std::abs(p.y) < 1.0 && std::abs(p.z) < 0.7;
  });
  compare_with_marching(SphereShape{0.9, false}, [&](Vec3 p) { return length(p) < 0.9; });
  compare_with_marching(CylinderShape{0.6, 0.8},
                        [&](Vec3 p) { return std::hypot(p.x, p.y) < 0.6 && std::abs(p.z) < 0.8; });
}

// Protects rooms: walls are seen from within and let pass from outside.
TEST_CASE("a room is seen from within") {
  const BoxShape room{{2, 3, 4}, true};
  const auto wall = intersect(room, {{0, 0, 0}, {1, 0, 0}}, 1e-6);
  REQUIRE(wall);
  CHECK(wall->range_m == 2);
  const auto through = intersect(room, {{-10, 0, 0}, {1, 0, 0}}, 1e-6);
  REQUIRE(through);
  CHECK(through->range_m == 12);
  CHECK_FALSE(intersect(room, {{10, 0, 0}, {1, 0, 0}}, 1e-6));
  const auto ball = intersect(SphereShape{5, true}, {{0, 0, 0}, {0, 0.6, 0.8}}, 1e-6);
  REQUIRE(ball);
  CHECK(ball->range_m == Approx(5));
}

// Protects against zero ranges and NaN: rays that start on a surface, run along one, or have zero
// components.
TEST_CASE("awkward rays find something true or nothing") {
  const BoxShape box{{1, 1, 1}, false};
  const auto from_face = intersect(box, {{-1, 0, 0}, {1, 0, 0}}, 1e-6);
  REQUIRE(from_face);
  CHECK(from_face->range_m == 2);
  CHECK_FALSE(intersect(box, {{-1, 0, 0}, {-1, 0, 0}}, 1e-6));
  CHECK_FALSE(intersect(box, {{-5, 2, 0}, {1, 0, 0}}, 1e-6));
  const CylinderShape cylinder{1, 1};
  const auto down_the_axis = intersect(cylinder, {{0, 0, 5}, {0, 0, -1}}, 1e-6);
  REQUIRE(down_the_axis);
  CHECK(down_the_axis->range_m == 4);
  CHECK_FALSE(intersect(cylinder, {{2, 0, 5}, {0, 0, -1}}, 1e-6));
  CHECK_FALSE(intersect(PlaneShape{}, {{0, 0, 1}, {1, 0, 0}}, 1e-6));
  CHECK_FALSE(intersect(PlaneShape{}, {{0, 0, 1}, {0, 0, 1}}, 1e-6));
  const auto below = intersect(PlaneShape{}, {{0, 0, -2}, {0, 0, 1}}, 1e-6);
  REQUIRE(below);
  CHECK(below->range_m == 2);
}

// Protects digits: a sphere of 1 cm seen from 1 km keeps its range to a nanometre.
TEST_CASE("a small far sphere is hit exactly") {
  const auto hit = intersect(SphereShape{0.01, false}, {{-1000, 0, 0}, {1, 0, 0}}, 1e-6);
  REQUIRE(hit);
  CHECK(hit->range_m == Approx(999.99).epsilon(1e-13));
}

// Protects the scene's distance field: points along the normals of faces, rims and corners.
TEST_CASE("signed distances are negative in what is solid") {
  const BoxShape box{{1, 2, 3}, false};
  CHECK(signed_distance_m(box, {0, 0, 0}) == -1);
  CHECK(signed_distance_m(box, {4, 6, 0}) == Approx(5));
  CHECK(signed_distance_m(box, {-2, -4, -5}) == Approx(3));
  CHECK(signed_distance_m(BoxShape{{1, 2, 3}, true}, {0.5, 0, 0}) == 0.5);
  CHECK(signed_distance_m(SphereShape{2, false}, {0, 0, 5}) == 3);
  CHECK(signed_distance_m(SphereShape{2, true}, {0, 0, 5}) == -3);
  const CylinderShape cylinder{1, 2};
  CHECK(signed_distance_m(cylinder, {0, 0.5, 0}) == -0.5);
  CHECK(signed_distance_m(cylinder, {0, 0.5, 2.25}) == 0.25);
  CHECK(signed_distance_m(cylinder, {4, 0, -6}) == Approx(5));
  CHECK(signed_distance_m(PlaneShape{}, {7, 8, -2}) == -2);
}
