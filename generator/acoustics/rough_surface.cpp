#include "acoustics/rough_surface.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr int kSteps = 2048;
constexpr double kGeometrical = 1000;  // of g
constexpr double kLowestDb = -300;
constexpr double kSmallestTerm = 1e-14;  // relative to the sum

// e^(-g) sum_n g^n / (n! n) e^(-q / n), from the largest term outward.
double series(double g, double q) {
  const auto term = [&](double n) {
    return std::exp(n * std::log(g) - g - std::lgamma(n + 1) - q / n) / n;
  };
  // The logarithm of a term is concave in n. Its derivative, log(g / n) + q / n^2, is 0 above g.
  double low = std::max(1.0, std::floor(g)), high = std::max(2.0, 2 * (g + std::sqrt(q) + 1));
  while (high - low > 1) {
    const double n = std::floor((low + high) / 2);
    (std::log(g / n) + q / (n * n) > 0 ? low : high) = n;
  }
  double sum = 0;
  for (double n = low; n >= 1; --n) {
    const double t = term(n);
    sum += t;
    if (t <= kSmallestTerm * sum) break;
  }
  for (double n = low + 1;; ++n) {
    const double t = term(n);
    sum += t;
    if (t <= kSmallestTerm * sum) return sum;
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
  BackscatterTable table;
  for (int i = 0; i <= kSteps; ++i) {
    const double grazing = kPi / 2 * i / kSteps;
    const double strength = rough_backscatter_strength(surface, wavelength_m, std::sin(grazing));
    table.grazing_rad.push_back(grazing);
    table.strength_db.push_back(strength > 0 ? std::max(10 * std::log10(strength), kLowestDb)
                                             : kLowestDb);
  }
  return table;
}

}  // namespace ensonify
