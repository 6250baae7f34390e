// The echo of an elastic sphere or spherical shell in water, with its resonances.
//
// Exact series of Faran (J. Acoust. Soc. Am. 23, 1951) for solid spheres and of Goodman and Stern
// (J. Acoust. Soc. Am. 34, 1962) for shells, with the boundary equations solved for each order.
// Materials do not absorb sound.
//
//   sphere_modes           coefficient of the scattered wave by order
//   sphere_backscatter_m   complex backscattering length
//   SphereTaps  sphere_taps   the same over a band, as delayed echoes
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
std::vector<std::complex<double>> sphere_modes(const ElasticSphere& sphere, const Water& water,
                                               double frequency_hz);

// f = (i/k) sum (-1)^n (2n+1) c_n, in m: at 1 m from the center the echo is f times the incident
// pressure there, and an echo of delay tau relative to that of the center has the phase
// e^(-i 2 pi f tau). The target strength is 20 log10 |f|.
std::complex<double> sphere_backscatter_m(const ElasticSphere& sphere, const Water& water,
                                          double frequency_hz);

// Delays are relative to that of the center; the first echo is near -2a/c.
struct SphereTaps {
  std::vector<Tap> taps;  // gains in m
  double error = 0;       // share of the energy over the band that the taps miss
};
// The band is bandwidth_hz wide around frequency_hz. The window of delays grows until the taps
// miss less than 1e-3 of the energy, up to 512 a/c, 2000/b and 256 taps.
SphereTaps sphere_taps(const ElasticSphere& sphere, const Water& water, double frequency_hz,
                       double bandwidth_hz);

}  // namespace ensonify
