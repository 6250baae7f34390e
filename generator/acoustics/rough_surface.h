// What the roughness of a reflecting surface takes from the specular echo and scatters.
//
//   RoughSurface  rough_backscatter_strength   at one angle of incidence
//   rough_backscatter_table                    at all of them
#pragma once

#include "core/surface.h"

namespace ensonify {

// A surface whose heights are normally distributed, with the autocorrelation h^2 e^(-(d/L)^2).
struct RoughSurface {
  double reflection = 0;     // of amplitudes
  double height_rms_m = 0;   // h
  double correlation_m = 0;  // L, of at least a wavelength or so

  bool operator==(const RoughSurface&) const = default;
};

// Backscatter cross-section of a unit of surface area, per steradian, by Kirchhoff's approximation
// (Beckmann and Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces, 1963,
// chapter 5), without the coherent part:
//   s = R^2 (k L)^2 / (4 pi cos^2 alpha) e^(-g) sum_n g^n / (n! n) e^(-(k L sin alpha)^2 / n),
//   g = 4 k^2 h^2 cos^2 alpha, k = 2 pi / lambda
// For g above 1000: its limit, R^2 / (8 pi q cos^4 alpha) e^(-tan^2 alpha / (2 q)), q = 2 h^2 / L^2.
// 0 at cos alpha = 0.
double rough_backscatter_strength(const RoughSurface& surface, double wavelength_m,
                                  double cos_incidence);

// The same from 0 to 90 degrees, at least -300 dB, in steps of 1/(5 k L) but at least 2048 and at
// most 65536 of them: linear in dB between them it is right to 0.05 dB, for k L above 13,000 less so.
BackscatterTable rough_backscatter_table(const RoughSurface& surface, double wavelength_m);

}  // namespace ensonify
