#include "acoustics/scattering.h"

#include <algorithm>

#include "acoustics/pattern.h"
#include "core/error.h"

namespace ensonify {
namespace {

double tabulated_db(const BackscatterTable& table, double grazing_rad) {
  const std::vector<double>& grazing = table.grazing_rad;
  ENSONIFY_ASSERT(grazing.size() >= 2 && grazing.size() == table.strength_db.size());
  const auto above = std::upper_bound(grazing.begin() + 1, grazing.end() - 1, grazing_rad);
  const std::size_t high = above - grazing.begin(), low = high - 1;
  // Rounding may leave the last row slightly below 90 degrees.
  const double part =
      std::clamp((grazing_rad - grazing[low]) / (grazing[high] - grazing[low]), 0.0, 1.0);
  return table.strength_db[low] + part * (table.strength_db[high] - table.strength_db[low]);
}

// s_b / cos(alpha): per unit of the rays' cross-section. Laws with a factor cos(alpha) are not
// divided by it, which would give 0/0 at grazing incidence.
double per_cross_section(const Material& material, double cos_incidence) {
  switch (material.law) {
    case ScatteringLaw::lommel_seeliger:
      return material.reflectivity;
    case ScatteringLaw::table:
      return backscatter_strength(material, cos_incidence) / cos_incidence;
    case ScatteringLaw::lambert:
      break;
  }
  // Lambert's law, which most rays meet, needs no power.
  if (material.lambert_exponent == 1) return material.reflectivity * cos_incidence;
  return material.reflectivity * std::pow(cos_incidence, material.lambert_exponent);
}

// Of the lobe of a smooth surface's roughness.
double rough_strength(const BackscatterTable& rough, double cos_incidence) {
  return std::pow(10.0, tabulated_db(rough, std::asin(cos_incidence)) / 10);
}

}  // namespace

double backscatter_strength(const Material& material, double cos_incidence) {
  switch (material.law) {
    case ScatteringLaw::lommel_seeliger:
      return material.reflectivity * cos_incidence;
    case ScatteringLaw::table:
      return std::pow(10.0, tabulated_db(material.table, std::asin(cos_incidence)) / 10);
    case ScatteringLaw::lambert:
      break;
  }
  return material.reflectivity * std::pow(cos_incidence, material.lambert_exponent + 1);
}

double surface_backscatter(const Material& material, double reflectivity_factor,
                           double cos_incidence) {
  const double strength = reflectivity_factor * backscatter_strength(material, cos_incidence);
  if (material.rough == nullptr || !(cos_incidence > 0)) return strength;
  return strength + rough_strength(*material.rough, cos_incidence);
}

ScattererMoments scatterer_moments(const Material& material, double reflectivity_factor,
                                   double cos_incidence, double range_m, double solid_angle_sr) {
  double strength = reflectivity_factor * per_cross_section(material, cos_incidence);
  if (material.rough != nullptr && cos_incidence > 0) {
    strength += rough_strength(*material.rough, cos_incidence) / cos_incidence;
  }
  const double sigma_squared = strength * range_m * range_m * solid_angle_sr;
  if (material.coherent != CoherentModel::rician) return {0, sigma_squared};
  return rician_moments(sigma_squared, material.rician_k);
}

double bistatic_strength(const Material& material, double cos_incidence, double cos_scattering) {
  if (cos_incidence == cos_scattering) return backscatter_strength(material, cos_incidence);
  const double product = cos_incidence * cos_scattering;
  switch (material.law) {
    case ScatteringLaw::lommel_seeliger:
      return material.reflectivity * 2 * product / (cos_incidence + cos_scattering);
    case ScatteringLaw::table:
      return std::sqrt(backscatter_strength(material, cos_incidence) *
                       backscatter_strength(material, cos_scattering));
    case ScatteringLaw::lambert:
      break;
  }
  return material.reflectivity * std::pow(product, (material.lambert_exponent + 1) / 2);
}

ScattererMoments bistatic_moments(const Material& material, double reflectivity_factor,
                                  double cos_incidence, double cos_scattering, double range_m,
                                  double solid_angle_sr) {
  if (cos_incidence == cos_scattering) {
    return scatterer_moments(material, reflectivity_factor, cos_incidence, range_m, solid_angle_sr);
  }
  const double sigma_squared = reflectivity_factor *
                               bistatic_strength(material, cos_incidence, cos_scattering) /
                               cos_incidence * range_m * range_m * solid_angle_sr;
  if (material.coherent != CoherentModel::rician) return {0, sigma_squared};
  return rician_moments(sigma_squared, material.rician_k);
}

std::complex<double> kirchhoff_amplitude_m(const Material& material, double wavelength_m,
                                           double cos_incidence, double range_m,
                                           double solid_angle_sr, double range_change_azimuth_m,
                                           double range_change_elevation_m) {
  const double reflection = coherent_reflection(material.reflection, material.roughness_rms_m,
                                                wavelength_m, cos_incidence);
  return {0, reflection * range_m * range_m * solid_angle_sr / wavelength_m *
                 sinc(2 * range_change_azimuth_m / wavelength_m) *
                 sinc(2 * range_change_elevation_m / wavelength_m)};
}

}  // namespace ensonify
