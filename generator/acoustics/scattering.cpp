#include "acoustics/scattering.h"

#include "acoustics/pattern.h"
#include "core/units.h"

namespace ensonify {

double backscatter_strength(const Material& material, double cos_incidence) {
  return material.reflectivity * std::pow(cos_incidence, material.lambert_exponent + 1);
}

ScattererMoments scatterer_moments(const Material& material, double reflectivity_factor,
                                   double cos_incidence, double range_m, double solid_angle_sr) {
  const double area = range_m * range_m * solid_angle_sr;
  return {0, reflectivity_factor * backscatter_strength(material, cos_incidence) / cos_incidence *
                 area};
}

std::complex<double> kirchhoff_amplitude_m(const Material& material, double wavelength_m,
                                           double cos_incidence, double range_m,
                                           double solid_angle_sr, double range_change_azimuth_m,
                                           double range_change_elevation_m) {
  const double kh = 2 * kPi / wavelength_m * material.roughness_rms_m * cos_incidence;
  return std::complex<double>(0, 1 / wavelength_m) *
         (material.reflection * std::exp(-2 * kh * kh) * range_m * range_m * solid_angle_sr *
          sinc(2 * range_change_azimuth_m / wavelength_m) *
          sinc(2 * range_change_elevation_m / wavelength_m));
}

}  // namespace ensonify
