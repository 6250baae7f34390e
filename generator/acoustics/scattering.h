// The strength of the sound that a surface element, its roughness, an edge or a target scatters.
//
//   cell_solid_angle_sr
//   backscatter_strength       of a unit of surface, by core/scattering_law.h
//   surface_backscatter        ... with roughness and reflectivity
//   scatterer_moments          mean and variance of a ray's scatterer
//   rician_moments
//   bistatic_strength  bistatic_moments   for different directions of incidence and scattering
//   kirchhoff_amplitude_m      of a plane cell of a smooth surface
//   coherent_reflection
//   target_amplitude_m         of a point target
//   RoughSurface               what the roughness of a reflecting surface scatters:
//     rough_backscatter_strength  rough_backscatter_table   at one angle of incidence, at all
//   Wedge                      the edge of a rigid or soft wedge:
//     wedge_diffraction        back toward the source
//     kirchhoff_edge           the part that Kirchhoff's integral over the faces contains
//     fringe_diffraction       the rest
#pragma once

#include <cmath>
#include <complex>

#include "core/compile_targets.h"
#include "core/surface.h"
#include "core/units.h"

namespace ensonify {

// Exact solid angle of the ray cell [azimuth +- d/2] x [low, high] in elevation:
// d (sin high - sin low), in steradians.
ENSONIFY_HD inline double cell_solid_angle_sr(double azimuth_step_rad, double elevation_low_rad,
                                              double elevation_high_rad) {
  return azimuth_step_rad * (std::sin(elevation_high_rad) - std::sin(elevation_low_rad));
}

// Backscatter cross-section of a unit of surface area, per steradian, at cos alpha = sin(grazing):
// that of the material's law.
double backscatter_strength(const Material& material, double cos_incidence);

// s_b of a surface whose reflectivity is multiplied by a factor, with the lobe of its roughness:
// factor backscatter_strength + Material::rough. It is the expected |a|^2 of surface scatterers per
// unit of surface; the specular echo of smooth surfaces is not in it.
double surface_backscatter(const Material& material, double reflectivity_factor,
                           double cos_incidence);

// Mean and variance of the amplitude of one ray's scatterer, in m and m^2:
// sigma^2 = (factor s_b(alpha) + Material::rough) dA / cos(alpha), dA = r^2 dOmega. For rician, the mean is
// sigma sqrt(K/(K+1)) and the variance sigma^2/(K+1); otherwise the mean is 0. Not finite if
// cos_incidence is 0 and the law does not vanish there; the caller leaves such a ray out.
struct ScattererMoments {
  double mean_m = 0, variance_m2 = 0;
};
ScattererMoments scatterer_moments(const Material& material, double reflectivity_factor,
                                   double cos_incidence, double range_m, double solid_angle_sr);

// Scattering cross-section of a unit of surface area, per steradian, from one direction to another,
// each given by its cosine to the normal. Symmetric in both, and backscatter_strength if they are
// equal.
double bistatic_strength(const Material& material, double cos_incidence, double cos_scattering);

// The moments for two directions, equal to scatterer_moments if both cosines are equal: sigma^2 =
// factor bistatic_strength dS, where dS = r^2 dOmega / cos(incidence) is the area of the cell in
// which a ray found the element.
ScattererMoments bistatic_moments(const Material& material, double reflectivity_factor,
                                  double cos_incidence, double cos_scattering, double range_m,
                                  double solid_angle_sr);

// Splits sigma^2 into a constant and a random part in the ratio of K to 1.
ENSONIFY_HD inline ScattererMoments rician_moments(double sigma_squared_m2, double k) {
  return {std::sqrt(sigma_squared_m2 * k / (k + 1)), sigma_squared_m2 / (k + 1)};
}

// Kirchhoff's amplitude of a plane cell, in m: (i/lambda) R dA sinc(x_azimuth) sinc(x_elevation),
// where dA = r^2 dOmega = cos(alpha) dS, R is coherent_reflection, and x = 2 (change of range
// across the cell)/lambda along each of its two sides.
std::complex<double> kirchhoff_amplitude_m(const Material& material, double wavelength_m,
                                           double cos_incidence, double range_m,
                                           double solid_angle_sr, double range_change_azimuth_m,
                                           double range_change_elevation_m);

// R = reflection e^(-2 k^2 h^2 cos^2 alpha), k = 2 pi/lambda: the coherent reflection of a rough
// surface.
ENSONIFY_HD inline double coherent_reflection(double reflection, double roughness_rms_m,
                                              double wavelength_m, double cos_incidence) {
  const double kh = 2.0 * kPi / wavelength_m * roughness_rms_m * cos_incidence;
  return reflection * std::exp(-2.0 * kh * kh);
}

// Amplitude of a point target at 1 m: |a| = 10^(TS/20), in m.
ENSONIFY_HD inline double target_amplitude_m(double target_strength_db) {
  return std::pow(10.0, target_strength_db / 20.0);
}

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

// Two plane faces that meet at the exterior angle `exterior_rad`, above pi and at most 2 pi.
struct Wedge {
  double exterior_rad = 0;
  bool rigid = true;  // otherwise soft
};

// Keller's coefficient f back toward a source at the angle phi from one face, 0 ... exterior_rad,
// across the edge. An edge element dl has the amplitude f dl/(2 pi), in m
// (Ufimtsev, Fundamentals of the Physical Theory of Diffraction, 2007, chapters 2 and 4):
//   f = sin(pi/n)/n [1/(cos(pi/n) - 1) +- 1/(cos(pi/n) - cos(2 phi/n))],  exterior_rad = n pi,
// + rigid, - soft. Infinite where a face is seen at normal incidence.
double wedge_diffraction(const Wedge& wedge, double angle_rad);

// The same by Kirchhoff's integral: -+ tan(phi)/2 for each face that the source sees, where phi is
// the angle from this face.
double kirchhoff_edge(const Wedge& wedge, double angle_rad);

// wedge_diffraction - kirchhoff_edge: what is added to Kirchhoff's integral. Finite everywhere.
double fringe_diffraction(const Wedge& wedge, double angle_rad);

}  // namespace ensonify
