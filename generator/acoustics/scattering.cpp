#include "acoustics/scattering.h"

#include <variant>

#include "acoustics/pattern.h"

namespace ensonify {
namespace {

// s_b / cos(alpha): per unit of the rays' cross-section.
double per_cross_section(const Material& material, double cos_incidence) {
  return std::visit(
      [&](const auto& law) { return law.per_cross_section(material.reflectivity, cos_incidence); },
      material.law);
}

// Of the lobe of a smooth surface's roughness.
double rough_strength(const BackscatterTable& rough, double cos_incidence) {
  return std::pow(10.0, tabulated_db(rough, std::asin(cos_incidence)) / 10);
}

}  // namespace

double backscatter_strength(const Material& material, double cos_incidence) {
  return std::visit(
      [&](const auto& law) { return law.backscatter(material.reflectivity, cos_incidence); },
      material.law);
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
  return std::visit(
      [&](const auto& law) {
        return law.bistatic(material.reflectivity, cos_incidence, cos_scattering);
      },
      material.law);
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
