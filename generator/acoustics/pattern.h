// Beam patterns: amplitude against angle.
//
//   line_pattern                                   uniform line
//   hann_line  taylor_line  chebyshev_line         shaded lines, against u
//   make_shaded_line  shaded_line  shaded_pattern  one of them: azimuth, receive
//   first_zero_rad                                 of one of them
//   elevation_pattern  two_direction_pattern       elevation, two-way
//   array_weights                                  of single elements
//   transmit_pattern                               azimuth, transmission
#pragma once

#include <cmath>
#include <vector>

#include "core/compile_targets.h"
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
ENSONIFY_HD inline double line_pattern(double angle_rad, double width_rad) {
  return sinc(0.884 * std::sin(angle_rad) / width_rad);
}

// sinc(u) / (1 - u^2): a line weighted by a raised cosine that is zero at its ends.
ENSONIFY_HD inline double hann_line(double u) {
  const double v = std::abs(u);
  if (v < 0.5) return sinc(v) / (1.0 - v * v);
  return sinc(1.0 - v) / (v * (1.0 + v));  // the same, but finite at u = 1
}

// sinc(u) prod_{n=1}^{nbar-1} (1 - u^2/(sigma^2 (A^2 + (n - 1/2)^2))) / (1 - u^2/n^2).
ENSONIFY_HD inline double taylor_line(double u, int nbar, double a_squared, double sigma_squared) {
  const double v = std::abs(u);
  // The zero of the sine that is nearest to u is combined with the factor that has its pole there.
  const int pole = v < nbar - 0.5 ? static_cast<int>(v + 0.5) : 0;
  double product = sinc(v);
  if (pole > 0) {
    product = (pole % 2 == 1 ? 1.0 : -1.0) * sinc(pole - v) * pole * pole / (v * (pole + v));
  }
  for (int n = 1; n < nbar; ++n) {
    product *= 1.0 - v * v / (sigma_squared * (a_squared + (n - 0.5) * (n - 0.5)));
    if (n != pole) product /= 1.0 - v * v / (static_cast<double>(n) * n);
  }
  return product;
}

// cos(pi sqrt(u^2 - A^2)) / cosh(pi A).
ENSONIFY_HD inline double chebyshev_line(double u, double a_squared) {
  const double square = u * u - a_squared;
  const double top =
      square < 0 ? std::cosh(kPi * std::sqrt(-square)) : std::cos(kPi * std::sqrt(square));
  return top / std::cosh(kPi * std::sqrt(a_squared));
}

// The amplitude of a shaded line aperture. With u = aperture sin(angle), aperture in wavelengths,
// B(0) = 1:
//   uniform    sinc(u), aperture = 0.884 / width (Choi et al. 2021, Eq 17)
//   hann       hann_line
//   taylor     taylor_line with sigma = nbar / sqrt(A^2 + (nbar - 1/2)^2),
//              cosh(pi A) = 10^(-side_lobe_db/20)
//              (Taylor, IRE Trans. Antennas Propag. 3, 1955)
//   chebyshev  chebyshev_line, A as before: the limit of Dolph's array of many elements
//              (van der Maas, J. Appl. Phys. 25, 1954)
// Shaded lines get the aperture for which B(width / 2) = 1/sqrt(2) at small widths. Needs
// side_lobe_db < 0 and nbar >= 1; Taylor's side lobes reach side_lobe_db only if nbar is at least
// about 2 A^2 + 1/2.
ShadedLine make_shaded_line(const BeamShading& shading, double width_rad);

// The amplitude of a line at u = aperture sin(angle).
ENSONIFY_HD inline double shaded_line(const ShadedLine& line, double u) {
  switch (line.shading.kind) {
    case Shading::hann:
      return hann_line(u);
    case Shading::taylor:
      return taylor_line(u, line.shading.nbar, line.a_squared, line.sigma_squared);
    case Shading::chebyshev:
      return chebyshev_line(u, line.a_squared);
    case Shading::uniform:
      break;
  }
  return sinc(u);
}

// The angle of the first zero beside the main lobe, 90 degrees if there is none.
double first_zero_rad(const ShadedLine& line);

// In azimuth: one-way receive amplitude B_az.
ENSONIFY_HD inline double shaded_pattern(const ShadedLine& line, double angle_rad) {
  return shaded_line(line, line.aperture * std::sin(angle_rad));
}

// Two-way amplitude B_el, applied once (Choi et al. 2021, Eq 18-22): line_pattern, or the pattern
// of the sonar's shaded elevation_line.
ENSONIFY_HD inline double elevation_pattern(const Sonar& sonar, double elevation_rad) {
  if (sonar.elevation_line.shading.kind == Shading::uniform) {
    return line_pattern(elevation_rad, sonar.elevation_width_rad);
  }
  return shaded_pattern(sonar.elevation_line, elevation_rad);
}

// The two-way pattern of sound that departs and arrives in different directions, from its values in
// both: h(departure) h(arrival) with h = sqrt|B| and the sign of the arrival; B if both are equal.
ENSONIFY_HD inline double two_direction_pattern(double departure, double arrival) {
  if (departure == arrival) return arrival;
  return std::copysign(std::sqrt(std::abs(departure * arrival)), arrival);
}

// Weights of a line of elements, [elements], with the sum 1. As a function of
// u = elements spacing sin(angle) / lambda, the line has the continuous pattern of the same shading
// at every integer u below elements / 2 (Woodward and Lawson, J. IEE 95, 1948). For chebyshev it
// has the pattern of Dolph's array with the same number of elements, whose side lobes are all
// equal. Needs elements >= 1.
std::vector<double> array_weights(const BeamShading& shading, int elements);

// One-way transmit amplitude in azimuth, sinc(0.442946 sin(azimuth) / sin(width/2)): -3 dB at
// exactly +- width/2. Width 0: 1 everywhere. Needs width <= pi.
ENSONIFY_HD inline double transmit_pattern(double azimuth_rad, double width_rad) {
  if (width_rad == 0) return 1.0;
  return sinc(0.4429464707 * std::sin(azimuth_rad) / std::sin(width_rad / 2));
}

}  // namespace ensonify
