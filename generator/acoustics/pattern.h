// Beam patterns: amplitude against angle.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/units.h"

namespace ensonify {

// sin(pi x) / (pi x).
ENSONIFY_HD inline double sinc(double x) {
  const double y = kPi * x;
  // The series is exact to 1e-17 here, where the quotient would be 0/0.
  if (std::abs(y) < 1e-4) return 1.0 - y * y / 6.0;
  return std::sin(y) / y;
}

// sinc(0.884 sin(angle) / width), signed; -3 dB full width = width_rad for small widths.
// In azimuth: one-way receive amplitude B_az (Choi et al. 2021, Eq 17).
// In elevation: two-way amplitude B_el, applied once (Eq 18-22).
ENSONIFY_HD inline double line_pattern(double angle_rad, double width_rad) {
  return sinc(0.884 * std::sin(angle_rad) / width_rad);
}

}  // namespace ensonify
