// The color of a surface seen through water. One bounce of light, no shadows, no forward
// scattering: docs/limits.md.
//
//   daylight_at   at a height
//   veil_at       the color of endless water
//   SeenPoint  seen_surface  seen_water   what reaches the camera
//   srgb          as 8 bits
#pragma once

#include <cstdint>

#include "core/camera.h"

namespace ensonify {

// E = daylight exp(-attenuation_per_m d) at a depth d below the water surface; d = 0 above it, and
// where there is none.
Rgb daylight_at(const Camera& camera, double z_m);

// B = veil (E + lamp), with E at the height of the camera.
Rgb veil_at(const Camera& camera, double camera_z_m);

struct SeenPoint {
  Rgb color;                 // share of the light that it reflects
  double z_m = 0;            // in the world
  double range_m = 0;        // from the camera
  double normal_z = 0;       // of the unit normal on the camera's side, upward
  double cos_incidence = 0;  // of the ray
};

// exposure (J exp(-attenuation_per_m r) + B (1 - exp(-backscatter_per_m r))), with
//   J = color (E (1 + normal_z) / 2 + lamp cos_incidence exp(-attenuation_per_m r) / r^2)
// and E at the height of the point: daylight from all of the upper half space, and a lamp in the
// place of the camera.
Rgb seen_surface(const Camera& camera, const Rgb& veil, const SeenPoint& point);

// exposure B; black in a color that does not scatter.
Rgb seen_water(const Camera& camera, const Rgb& veil);

// The transfer function of IEC 61966-2-1, from 0 ... 1 to 0 ... 255, rounded; values beyond are cut
// off.
std::uint8_t srgb(double linear);

}  // namespace ensonify
