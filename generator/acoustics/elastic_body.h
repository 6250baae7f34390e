// The echo of an elastic sphere or cylinder in water, solid or a shell, with its resonances.
//
// Exact series of Faran (J. Acoust. Soc. Am. 23, 1951) for solid bodies and of Goodman and Stern
// (J. Acoust. Soc. Am. 34, 1962) for shells, with the boundary equations solved for each order.
// Materials do not absorb sound. A cylinder is infinite and heard at right angles to its axis.
//
//   sphere_modes  cylinder_modes   coefficients of the scattered wave by order
//   sphere_backscatter_m           complex backscattering length
//   cylinder_backscatter           the same per length of a cylinder
//   ElasticTaps  sphere_taps  cylinder_taps   over a band, as delayed echoes
#pragma once

#include <complex>
#include <vector>

#include "acoustics/taps.h"
#include "core/elastic.h"
#include "core/sonar.h"

namespace ensonify {

// c_n, n = 0, 1, ...: with the incident plane wave e^(-ikz) = sum (2n+1) (-i)^n j_n(kr) P_n, the
// scattered wave is sum (2n+1) (-i)^n c_n h_n^(2)(kr) P_n, for the time factor e^(+i 2 pi f t).
// |1 + 2 c_n| = 1. ka + 4 (ka)^(1/3) + 10 orders.
std::vector<std::complex<double>> sphere_modes(const ElasticBody& sphere, const Water& water,
                                               double frequency_hz);

// f = (i/k) sum (-1)^n (2n+1) c_n, in m: at 1 m from the center the echo is f times the incident
// pressure there, and an echo of delay tau relative to that of the center has the phase
// e^(-i 2 pi f tau). The target strength is 20 log10 |f|.
std::complex<double> sphere_backscatter_m(const ElasticBody& sphere, const Water& water,
                                          double frequency_hz);

// c_n, n = 0, 1, ...: with the incident plane wave e^(ikx) = sum e_n i^n J_n(kr) cos(n theta), e_0 = 1
// and otherwise 2, the scattered wave is sum e_n i^n c_n H_n^(2)(kr) cos(n theta).
std::vector<std::complex<double>> cylinder_modes(const ElasticBody& cylinder, const Water& water,
                                                 double frequency_hz);

// (i/pi) sum (-1)^n e_n c_n: an element dl of the axis echoes as a point with this times dl, in m
// (Stanton, J. Acoust. Soc. Am. 83, 1988). Phases are those of sphere_backscatter_m.
std::complex<double> cylinder_backscatter(const ElasticBody& cylinder, const Water& water,
                                          double frequency_hz);

// Delays are relative to that of the center or axis; the first echo is near -2a/c.
struct ElasticTaps {
  std::vector<Tap> taps;  // gains in m, of a cylinder without a unit
  double error = 0;       // share of the energy over the band that the taps miss
};
// The band is bandwidth_hz wide around frequency_hz. The window of delays grows until the taps
// miss less than 1e-3 of the energy, up to 512 a/c, 2000/b and 256 taps.
ElasticTaps sphere_taps(const ElasticBody& sphere, const Water& water, double frequency_hz,
                       double bandwidth_hz);
ElasticTaps cylinder_taps(const ElasticBody& cylinder, const Water& water, double frequency_hz,
                          double bandwidth_hz);

}  // namespace ensonify
