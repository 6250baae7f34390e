#include "acoustics/scattering.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <variant>

#include "acoustics/pattern.h"
#include "core/units.h"

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

namespace {

constexpr double kLeastSteps = 2048, kMostSteps = 65536;
constexpr double kGeometrical = 1000;  // of g
constexpr double kLowestDb = -300;
constexpr double kSmallestTerm = 1e-14;  // relative to the sum

// log(n!) - (n log(n) - n + log(2 pi n)/2), by Stirling's series where it is exact to 1e-8.
double stirling_rest(double n) {
  double rest = 0;
  for (; n < 10; ++n) rest += (n + 0.5) * std::log1p(1 / n) - 1;
  return rest + 1 / (12 * n) - 1 / (360 * n * n * n);
}

// e^(-g) sum_n g^n / (n! n) e^(-q / n), from the largest term outward.
double series(double g, double q) {
  // The logarithm of a term is concave in n. Its derivative, log(g / n) + q / n^2, is 0 above g.
  double low = std::max(1.0, std::floor(g)), high = std::max(2.0, 2 * (g + std::sqrt(q) + 1));
  while (high - low > 1) {
    const double n = std::floor((low + high) / 2);
    (std::log(g / n) + q / (n * n) > 0 ? low : high) = n;
  }
  // Terms relative to the largest one, which may be too small for a double.
  const auto log_term = [&](double n) {
    return n * std::log(g / n) + n - g - std::log(2 * kPi * n) / 2 - stirling_rest(n) - q / n -
           std::log(n);
  };
  const double most = log_term(low);
  double sum = 0;
  for (double n = low; n >= 1; --n) {
    const double t = std::exp(log_term(n) - most);
    sum += t;
    if (!(t > kSmallestTerm * sum)) break;
  }
  for (double n = low + 1;; ++n) {
    const double t = std::exp(log_term(n) - most);
    sum += t;
    if (!(t > kSmallestTerm * sum)) return sum * std::exp(most);
  }
}

}  // namespace

double rough_backscatter_strength(const RoughSurface& surface, double wavelength_m,
                                  double cos_incidence) {
  const double cosine = cos_incidence;
  if (!(cosine > 0) || surface.height_rms_m == 0) return 0;
  const double k = 2 * kPi / wavelength_m, cos_squared = cosine * cosine;
  const double sin_squared = std::max(0.0, 1 - cos_squared);
  const double g = 4 * k * k * surface.height_rms_m * surface.height_rms_m * cos_squared;
  const double reflected = surface.reflection * surface.reflection;
  if (g > kGeometrical) {
    const double slope = surface.height_rms_m / surface.correlation_m;
    const double q = 2 * slope * slope;
    return reflected / (8 * kPi * q * cos_squared * cos_squared) *
           std::exp(-sin_squared / cos_squared / (2 * q));
  }
  const double kl = k * surface.correlation_m;
  return reflected * kl * kl / (4 * kPi * cos_squared) * series(g, kl * kl * sin_squared);
}

BackscatterTable rough_backscatter_table(const RoughSurface& surface, double wavelength_m) {
  const double kl = 2 * kPi / wavelength_m * surface.correlation_m;
  const int steps = static_cast<int>(std::clamp(8 * kl, kLeastSteps, kMostSteps));
  BackscatterTable table;
  for (int i = 0; i <= steps; ++i) {
    const double grazing = kPi / 2 * i / steps;
    const double strength = rough_backscatter_strength(surface, wavelength_m, std::sin(grazing));
    table.grazing_rad.push_back(grazing);
    table.strength_db.push_back(strength > 0 ? std::max(10 * std::log10(strength), kLowestDb)
                                             : kLowestDb);
  }
  return table;
}

double wedge_diffraction(const Wedge& wedge, double angle_rad) {
  const double n = wedge.exterior_rad / kPi;
  const double cosine = std::cos(kPi / n);
  const double away = 1 / (cosine - 1), back = 1 / (cosine - std::cos(2 * angle_rad / n));
  return std::sin(kPi / n) / n * (wedge.rigid ? away + back : away - back);
}

double kirchhoff_edge(const Wedge& wedge, double angle_rad) {
  const double other_rad = wedge.exterior_rad - angle_rad;
  double sum = 0;
  if (angle_rad < kPi) sum += std::tan(angle_rad) / 2;
  if (other_rad < kPi) sum += std::tan(other_rad) / 2;
  return wedge.rigid ? -sum : sum;
}

double fringe_diffraction(const Wedge& wedge, double angle_rad) {
  constexpr double kNear_rad = 1e-4;  // of normal incidence, where both terms have a pole
  const auto difference = [&](double a) {
    return wedge_diffraction(wedge, a) - kirchhoff_edge(wedge, a);
  };
  for (const double pole : {kPi / 2, wedge.exterior_rad - kPi / 2}) {
    if (std::abs(angle_rad - pole) < kNear_rad) {
      return (difference(pole - kNear_rad) + difference(pole + kNear_rad)) / 2;
    }
  }
  return difference(angle_rad);
}

}  // namespace ensonify
