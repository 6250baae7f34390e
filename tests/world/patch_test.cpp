// Patches of surfaces: halves, balls and points.
#include "world/patch.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"

using namespace ensonify;

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
        for (const auto& half : halves_of(p)) for_parts(half, levels - 1, visit);
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
