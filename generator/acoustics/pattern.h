// Beam patterns: amplitude against angle.
//
//   line_pattern                               uniform line: elevation, two-way
//   ReceivePattern  make_...  receive_pattern  shaded line: azimuth, receive
//   transmit_pattern                           azimuth, transmission
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/sonar.h"
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

// The receive amplitude of a shaded line aperture. With u = aperture sin(angle), aperture in
// wavelengths, B(0) = 1:
//   uniform    sinc(u), aperture = 0.884 / width (Choi et al. 2021, Eq 17)
//   hann       sinc(u) / (1 - u^2)
//   taylor     sinc(u) prod_{n=1}^{nbar-1} (1 - u^2/(sigma^2 (A^2 + (n - 1/2)^2))) / (1 - u^2/n^2),
//              sigma = nbar / sqrt(A^2 + (nbar - 1/2)^2), cosh(pi A) = 10^(-side_lobe_db/20)
//              (Taylor, IRE Trans. Antennas Propag. 3, 1955)
//   chebyshev  cos(pi sqrt(u^2 - A^2)) / cosh(pi A), cosh below u = A: the limit of Dolph's array
//              of many elements (van der Maas, J. Appl. Phys. 25, 1954)
// The shaded ones get the aperture that makes B(width / 2) = 1/sqrt(2) at small widths.
struct ReceivePattern {
  BeamShading shading;
  double aperture = 0;       // in wavelengths
  double a_squared = 0;      // A^2
  double sigma_squared = 0;  // of taylor
};
ReceivePattern make_receive_pattern(const BeamShading& shading, double width_rad);
double receive_pattern(const ReceivePattern& pattern, double angle_rad);

// One-way transmit amplitude in azimuth, sinc(0.442946 sin(azimuth) / sin(width/2)): -3 dB at
// exactly +- width/2. Width 0: 1 everywhere. Needs width <= pi.
ENSONIFY_HD inline double transmit_pattern(double azimuth_rad, double width_rad) {
  if (width_rad == 0) return 1.0;
  return sinc(0.4429464895 * std::sin(azimuth_rad) / std::sin(width_rad / 2));
}

}  // namespace ensonify
