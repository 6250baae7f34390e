#include "camera/color.h"

#include <algorithm>
#include <cmath>

namespace ensonify {

Rgb daylight_at(const Camera& camera, double z_m) {
  const double surface_z_m = camera.light.surface_z_m.value_or(z_m);
  const double depth_m = std::max(0.0, surface_z_m - z_m);
  Rgb light;
  for (std::size_t c = 0; c < 3; ++c) {
    light[c] = camera.light.daylight * std::exp(-camera.water.attenuation_per_m[c] * depth_m);
  }
  return light;
}

Rgb veil_at(const Camera& camera, double camera_z_m) {
  Rgb veil = daylight_at(camera, camera_z_m);
  for (std::size_t c = 0; c < 3; ++c) {
    veil[c] = camera.water.veil[c] * (veil[c] + camera.light.lamp);
  }
  return veil;
}

Rgb seen_surface(const Camera& camera, const Rgb& veil, const SeenPoint& point) {
  const auto& [color, z_m, range_m, normal_z, cos_incidence] = point;
  const Rgb daylight = daylight_at(camera, z_m);
  const double lamp = camera.light.lamp * cos_incidence / (range_m * range_m);
  Rgb seen;
  for (std::size_t c = 0; c < 3; ++c) {
    const double direct = std::exp(-camera.water.attenuation_per_m[c] * range_m);
    const double back = std::exp(-camera.water.backscatter_per_m[c] * range_m);
    const double lit = color[c] * (daylight[c] * (1 + normal_z) / 2 + lamp * direct);
    seen[c] = camera.light.exposure * (lit * direct + veil[c] * (1 - back));
  }
  return seen;
}

Rgb seen_water(const Camera& camera, const Rgb& veil) {
  Rgb seen{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (camera.water.backscatter_per_m[c] > 0) seen[c] = camera.light.exposure * veil[c];
  }
  return seen;
}

std::uint8_t srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double coded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * coded));
}

}  // namespace ensonify
