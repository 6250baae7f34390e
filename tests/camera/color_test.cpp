// Colors against the closed form of Akkaynak and Treibitz (2018).
#include "camera/color.h"

#include <cmath>

#include "catch.h"

using namespace ensonify;

namespace {

Camera camera_in(const Rgb& attenuation, const Rgb& backscatter, const Rgb& veil) {
  Camera camera;
  camera.water = {attenuation, backscatter, veil};
  return camera;
}

}  // namespace

// Protects the model: a level surface under daylight, seen through r meters of water.
TEST_CASE("colors after r meters of water are those of the model") {
  Camera camera = camera_in({0.3, 0.1, 0.2}, {0.25, 0.15, 0.05}, {0.02, 0.1, 0.3});
  camera.light = {.daylight = 1.5, .exposure = 2, .surface_z_m = 10.0};
  const Rgb color = {0.8, 0.5, 0.2};
  const Rgb veil = veil_at(camera, 6);
  for (const double r : {0.5, 2.0, 9.0}) {
    const Rgb seen = seen_surface(camera, veil, {color, 4, r, 1, 1});
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = camera.water.attenuation_per_m[c], b = camera.water.backscatter_per_m[c];
      const double direct = color[c] * 1.5 * std::exp(-a * 6) * std::exp(-a * r);
      const double back = camera.water.veil[c] * 1.5 * std::exp(-a * 4) * (1 - std::exp(-b * r));
      CHECK(seen[c] == Approx(2 * (direct + back)).epsilon(1e-12));
    }
  }
}

// Protects the lamp: on the way out and back the water counts twice, and the light falls as 1 /
// r^2.
TEST_CASE("a lamp lights what is near") {
  Camera camera = camera_in({0.3, 0.1, 0.2}, {0, 0, 0}, {0, 0, 0});
  camera.light.daylight = 0;
  camera.light.lamp = 4;
  const Rgb seen = seen_surface(camera, veil_at(camera, 0), {{1, 0.5, 0.25}, 0, 2, -1, 0.6});
  for (std::size_t c = 0; c < 3; ++c) {
    const double expected = std::pow(0.5, static_cast<double>(c)) * 4 * 0.6 / 4 *
                            std::exp(-2 * 2 * camera.water.attenuation_per_m[c]);
    CHECK(seen[c] == Approx(expected).epsilon(1e-12));
  }
}

// Protects pixels without a surface: the limit of far surfaces, and black in clear water.
TEST_CASE("endless water has the color of its veil") {
  Camera camera = camera_in({0.3, 0.1, 0.2}, {0.3, 0.1, 0}, {0.02, 0.1, 0.3});
  const Rgb veil = veil_at(camera, 0);
  const Rgb far = seen_surface(camera, veil, {{1, 1, 1}, 0, 1e4, 0, 1});
  const Rgb water = seen_water(camera, veil);
  for (std::size_t c = 0; c < 3; ++c) CHECK(water[c] == Approx(far[c]).margin(1e-12));
  CHECK(water == Rgb{0.02, 0.1, 0});
}

// Protects 8 bits: values of IEC 61966-2-1.
TEST_CASE("linear light becomes sRGB") {
  CHECK(srgb(-1) == 0);
  CHECK(srgb(0.002) == 7);    // 12.92 * 0.002 * 255 = 6.59
  CHECK(srgb(0.214) == 127);  // 0.4998
  CHECK(srgb(0.5) == 188);    // 0.7354
  CHECK(srgb(1) == 255);
  CHECK(srgb(7) == 255);
}
