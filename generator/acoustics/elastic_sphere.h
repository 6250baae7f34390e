// The echo of an elastic sphere or spherical shell in water, with its resonances.
//
// Exact series of Faran (J. Acoust. Soc. Am. 23, 1951) for solid spheres and of Goodman and Stern
// (J. Acoust. Soc. Am. 34, 1962) for shells, with the boundary equations solved for each order.
// Materials do not absorb sound.
//
//   SphereMaterial  SphereFilling  ElasticSphere
//   sphere_modes           coefficient of the scattered wave by order
//   sphere_backscatter_m   complex backscattering length
//   SphereTaps  sphere_taps   the same over a band, as delayed echoes
#pragma once

#include <complex>
#include <vector>

#include "acoustics/taps.h"
#include "core/sonar.h"

namespace ensonify {

// Speeds of longitudinal and of shear waves; a shear speed of 0 is a fluid. The shear speed is
// below sqrt(3/4) of the longitudinal one, so that the compressibility is positive.
struct SphereMaterial {
  double density_kg_m3 = 0, speed_m_s = 0, shear_speed_m_s = 0;
};

// Tungsten carbide with 6 % cobalt: MacLennan and Dunn, J. Sound Vib. 97, 1984. Electrical-grade
// copper: Foote, J. Acoust. Soc. Am. 73, 1983. Rolled aluminum and mild steel: AIP Handbook, 3rd
// edition, 1972.
inline constexpr SphereMaterial kTungstenCarbide{14900, 6853, 4171};
inline constexpr SphereMaterial kCopper{8947, 4760, 2288.5};
inline constexpr SphereMaterial kAluminum{2700, 6420, 3040};
inline constexpr SphereMaterial kSteel{7850, 5960, 3235};

// The fluid in a shell; a density of 0 is a vacuum.
struct SphereFilling {
  double density_kg_m3 = 0, speed_m_s = 0;
};
inline constexpr SphereFilling kAir{1.2, 340};

struct ElasticSphere {
  double radius_m = 0;
  SphereMaterial material;
  double wall_m = 0;  // from the radius on: solid
  SphereFilling filling = {};
};

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
// miss less than 1e-3 of the energy, up to 512 a/c and 256 taps.
SphereTaps sphere_taps(const ElasticSphere& sphere, const Water& water, double frequency_hz,
                       double bandwidth_hz);

}  // namespace ensonify
