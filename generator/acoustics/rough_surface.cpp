#include "acoustics/rough_surface.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
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

}  // namespace ensonify
