// How much a patch of surface, or a target, throws back.
#pragma once

#include <cmath>

#include "core/host_device.h"

namespace ensonify {

// Exact solid angle of the ray cell [azimuth +- d/2] x [low, high] in elevation:
// d (sin high - sin low), in steradians.
ENSONIFY_HD inline double cell_solid_angle_sr(double azimuth_step_rad, double elevation_low_rad,
                                              double elevation_high_rad) {
  return azimuth_step_rad * (std::sin(elevation_high_rad) - std::sin(elevation_low_rad));
}

// Variance of a diffuse scatterer: sigma^2 = mu cos^n(alpha) dA with dA = r^2 dOmega, the part of
// the ray's cross-section; n = 1 is Lambert's law, n = 2 Eq 14 of Choi et al. 2021. In m^2.
ENSONIFY_HD inline double lambert_variance_m2(double reflectivity, double cos_incidence,
                                              double exponent, double range_m,
                                              double solid_angle_sr) {
  return reflectivity * std::pow(cos_incidence, exponent) * range_m * range_m * solid_angle_sr;
}

// Amplitude of a point target at 1 m: |a| = 10^(TS/20), in m.
ENSONIFY_HD inline double target_amplitude_m(double target_strength_db) {
  return std::pow(10.0, target_strength_db / 20.0);
}

}  // namespace ensonify
