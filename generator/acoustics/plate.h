// A plate between two fluids, as a model of the sound that a thin wall reflects and transmits.
//
//   PlateResponse  plate_response   at one frequency and angle
//   WallResponse  wall_response     over a band, as delayed echoes, for all angles
#pragma once

#include <complex>
#include <vector>

#include "acoustics/taps.h"
#include "core/sonar.h"
#include "core/surface.h"

namespace ensonify {

// Pressure of the reflected wave at the front, and of the transmitted one at the back, relative to
// that of the incident plane wave at the front. A delay tau is e^(-i 2 pi f tau).
struct PlateResponse {
  std::complex<double> reflected, transmitted;
};

// `sine` is that of the angle of incidence in the water, from 0 to 1. The plate is solid, with
// compressional and shear waves. Its symmetric and antisymmetric motions have the impedances
//   Z_S = -i omega rho / (alpha k_T^4) [(beta^2 - xi^2)^2 cot(alpha d/2) + 4 xi^2 alpha beta
//         cot(beta d/2)],
//   Z_A = the same with -tan in place of cot,
// where xi = k sine, alpha^2 = k_L^2 - xi^2 and beta^2 = k_T^2 - xi^2. With Z = rho_w c / cos:
// R +- T = (Z_SA - Z)/(Z_SA + Z) in water on both sides; with air inside T = 0 and
// R = (Z_in - Z)/(Z_in + Z), 2/Z_in = 1/Z_S + 1/Z_A. Brekhovskikh and Godin, Acoustics of Layered
// Media I (1990), chapter 4.
PlateResponse plate_response(const Wall& wall, const Water& water, double sine, double f_hz);

// The responses over a band, in steps of the sine of the angle of incidence.
struct WallResponse {
  struct Angle {
    // The transmitted wave is relative to the same wave through as much water as the wall is thick.
    std::vector<Tap> reflected, transmitted;
    double reflected_energy = 0, transmitted_energy = 0;  // sums over the taps
  };
  std::vector<Angle> by_sine;  // middles of equal steps from 0 to 1
  bool lets_through = false;

  const Angle& at(double sine) const;
};

WallResponse wall_response(const Wall& wall, const Water& water, double frequency_hz,
                           double bandwidth_hz);

}  // namespace ensonify
