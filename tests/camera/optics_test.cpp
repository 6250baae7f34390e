// The projection of points onto pixels and back, by numbers of another route.
#include <cmath>

#include "catch.h"
#include "core/camera.h"

using namespace ensonify;

namespace {

// A lens of strong barrel distortion, turned a little.
CameraOptics lens() {
  return {.width_px = 640,
          .height_px = 480,
          .focal_x_px = 420,
          .focal_y_px = 415,
          .center_x_px = 323.5,
          .center_y_px = 236,
          .k1 = -0.28,
          .k2 = 0.09,
          .p1 = 1e-3,
          .p2 = -7e-4,
          .k3 = -0.012};
}

}  // namespace

// Protects the convention: the formula of cv2.projectPoints, term by term.
TEST_CASE("a point projects as OpenCV's formula does") {
  // By hand: x = 0.25, y = -0.125, r2 = 0.078125.
  const double r2 = 0.078125;
  const double s = 1 - 0.28 * r2 + 0.09 * r2 * r2 - 0.012 * r2 * r2 * r2;
  const double x = s * 0.25 + 2 * 1e-3 * 0.25 * -0.125 - 7e-4 * (r2 + 2 * 0.0625);
  const double y = s * -0.125 + 1e-3 * (r2 + 2 * 0.015625) + 2 * -7e-4 * 0.25 * -0.125;
  const auto place = projected(lens(), {1, -0.5, 4});
  REQUIRE(place);
  CHECK(place->x == Approx(420 * x + 323.5).epsilon(1e-14));
  CHECK(place->y == Approx(415 * y + 236).epsilon(1e-14));
  CHECK_FALSE(projected(lens(), {1, -0.5, -4}));
  CHECK_FALSE(projected(lens(), {1, -0.5, 0}));
}

// Protects both directions: undistort, then project.
TEST_CASE("rays of pixels project back onto them") {
  const CameraOptics optics = lens();
  double worst_px = 0;
  for (int v = 0; v < optics.height_px; v += 13) {
    for (int u = 0; u < optics.width_px; u += 7) {
      const auto back = projected(optics, 3.7 * pixel_direction(optics, u, v));
      REQUIRE(back);
      worst_px = std::max({worst_px, std::abs(back->x - u), std::abs(back->y - v)});
    }
  }
  CHECK(worst_px < 1e-9);
  CHECK_FALSE(unseen_pixel(optics));
}

// Protects against images that a distortion folds: r (1 + k1 r^2) with k1 < 0 has its largest value
// 2/3 (3 |k1|)^(-1/2) at r = (3 |k1|)^(-1/2).
TEST_CASE("a folded image is found where the radial distortion turns back") {
  CameraOptics optics{.width_px = 201,
                      .height_px = 201,
                      .focal_x_px = 100,
                      .focal_y_px = 100,
                      .center_x_px = 100,
                      .center_y_px = 100,
                      .k1 = -0.1};
  const double turn = 2.0 / 3 / std::sqrt(0.3);  // 1.217, beyond the side at 1.005, not the corner
  CHECK(undistorted(optics, {0.99 * turn, 0}));
  CHECK_FALSE(undistorted(optics, {1.01 * turn, 0}));
  CHECK(unseen_pixel(optics) == std::array{0, 0});
  CHECK_FALSE(projected(optics, {2, 0, 1}));  // farther aside than the fold
  optics.k1 = -0.05;
  CHECK_FALSE(unseen_pixel(optics));
}
