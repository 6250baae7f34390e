#include "world/shapes.h"

#include <cmath>
#include <vector>

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

namespace {

std::vector<Patch> samples() {
  return {TrianglePatch{{0, 0, 0}, {3, 0, 1}, {0.5, 1, -2}},
          RectanglePatch{{1, 2, 3}, {0, 4, 0}, {0, 0, 0.3}},
          SpherePatch{2, {-kPi, kPi}, {-2, 2}},
          SpherePatch{2, {0.1, 0.9}, {1.7, 2}},
          MantlePatch{0.5, {-kPi, kPi}, {-3, 3}},
          DiscPatch{1, {-kPi, kPi}, {0, 0.25}}};
}

double area_of(const Patch& patch) {
  return std::visit([](const auto& p) { return area_m2(p); }, patch);
}

Vec3 point_in(const Patch& patch, double u, double v) {
  return std::visit([&](const auto& p) { return point_of(p, u, v).position_m; }, patch);
}

template <class Visit>
void for_parts(const Patch& patch, int levels, const Visit& visit) {
  if (levels == 0) return visit(patch);
  std::visit(
      [&](const auto& p) {
        for (const auto& part : halves_of(p)) for_parts(part, levels - 1, visit);
      },
      patch);
}

}  // namespace

// Protects the strength of every scatterer on a surface: its leaf is 2^-levels of the whole.
TEST_CASE("parts of a patch have equal areas and add up to it") {
  CHECK(area_of(samples()[2]) == Approx(4 * kPi * 4));
  CHECK(area_of(samples()[4]) == Approx(2 * kPi * 0.5 * 6));
  CHECK(area_of(samples()[5]) == Approx(kPi * 0.25));
  for (const Patch& patch : samples()) {
    double sum = 0;
    for_parts(patch, 10, [&](const Patch& part) {
      sum += area_of(part);
      REQUIRE(area_of(part) * 1024 == Approx(area_of(patch)).epsilon(1e-9));
    });
    CHECK(sum == Approx(area_of(patch)).epsilon(1e-9));
  }
}

// Protects culling: what a ball is not heard in, no point of the patch is.
TEST_CASE("the ball of a patch holds all its points") {
  for (const Patch& patch : samples()) {
    for (const int levels : {0, 1, 2, 3, 7}) {
      std::uint64_t number = 0;
      for_parts(patch, levels, [&](const Patch& part) {
        const Ball ball = std::visit([](const auto& p) { return ball_of(p); }, part);
        for (int i = 0; i < 20; ++i) {
          const Philox4 w = random_words(1, 0, number++, 0);
          const Vec3 p = point_in(part, uniform_from_word(w.v[0]), uniform_from_word(w.v[1]));
          REQUIRE(length(p - ball.centre_m) <= ball.radius_m * (1 + 1e-12));
        }
      });
    }
  }
}

// Protects the density of tiles from slivers: ten halvings leave parts about as wide as high.
TEST_CASE("parts of a patch are compact") {
  for (const Patch& patch : samples()) {
    for_parts(patch, 10, [&](const Patch& part) {
      const Ball ball = std::visit([](const auto& p) { return ball_of(p); }, part);
      REQUIRE(ball.radius_m * ball.radius_m < 8 * area_of(part));
    });
  }
}

// Protects levels against points that crowd within a leaf: half of them lie in either half.
TEST_CASE("points are uniform over a patch") {
  for (const Patch& patch : samples()) {
    Vec3 mean{}, of_parts{};
    constexpr int kPoints = 40'000;
    for (int i = 0; i < kPoints; ++i) {
      const Philox4 w = random_words(2, 0, i, 0);
      mean = mean + (1.0 / kPoints) *
                        point_in(patch, uniform_from_word(w.v[0]), uniform_from_word(w.v[1]));
    }
    for_parts(patch, 14, [&](const Patch& part) {
      of_parts = of_parts + std::ldexp(1.0, -14) * point_in(part, 0.5, 0.5);
    });
    const Ball ball = std::visit([](const auto& p) { return ball_of(p); }, patch);
    // Three standard errors of a coordinate of at most that spread.
    CHECK(length(mean - of_parts) < 3 * ball.radius_m / std::sqrt(double(kPoints)) * 1.8);
  }
}
