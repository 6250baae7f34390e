#include "acoustics/pattern.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace ensonify {
namespace {

// Where the main lobe has fallen to -3 dB.
double half_power_u(const ShadedLine& line) {
  const double level = std::sqrt(0.5);
  constexpr double kStep = 1.0 / 16;  // far less than a main lobe
  double high = kStep;
  while (shaded_line(line, high) > level) high += kStep;
  double low = high - kStep;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (shaded_line(line, middle) > level ? low : high) = middle;
  }
  return (low + high) / 2;
}

// T_(elements-1)(x0 cos(pi u / elements)) relative to its main lobe; all side lobes are equal.
// Dolph, Proc. IRE 34, 1946.
double dolph_array(double side_lobe_db, int elements, double u) {
  const int order = elements - 1;
  const double height = std::pow(10.0, -side_lobe_db / 20);
  const double x = std::cosh(std::acosh(height) / order) * std::cos(kPi * u / elements);
  return (x > 1 ? std::cosh(order * std::acosh(x)) : std::cos(order * std::acos(x))) / height;
}

}  // namespace

ShadedLine make_shaded_line(const BeamShading& shading, double width_rad) {
  ENSONIFY_ASSERT(width_rad > 0);
  ShadedLine line{shading, 0.884 / width_rad, 0, 0};
  if (shading.kind == Shading::uniform) return line;
  if (shading.kind != Shading::hann) {
    ENSONIFY_ASSERT(shading.side_lobe_db < 0);
    const double a = std::acosh(std::pow(10.0, -shading.side_lobe_db / 20)) / kPi;
    line.a_squared = a * a;
  }
  if (shading.kind == Shading::taylor) {
    ENSONIFY_ASSERT(shading.nbar >= 1);
    const double nbar = shading.nbar;
    line.sigma_squared = nbar * nbar / (line.a_squared + (nbar - 0.5) * (nbar - 0.5));
  }
  line.aperture = 2 * half_power_u(line) / width_rad;
  return line;
}

double first_zero_rad(const ShadedLine& line) {
  constexpr double kStep = 1.0 / 16;
  double high = kStep;
  while (shaded_line(line, high) > 0) high += kStep;
  double low = high - kStep;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (shaded_line(line, middle) > 0 ? low : high) = middle;
  }
  return std::asin(std::min(1.0, high / line.aperture));
}

std::vector<double> array_weights(const BeamShading& shading, int elements) {
  const ShadedLine line = make_shaded_line(shading, 1.0);  // any width: only u matters
  const auto value_at = [&](int u) {
    return shading.kind == Shading::chebyshev ? dolph_array(shading.side_lobe_db, elements, u)
                                              : shaded_line(line, u);
  };
  std::vector<double> values;
  for (int m = 1; 2 * m < elements; ++m) values.push_back(value_at(m));
  // The weights of the two halves are equal.
  std::vector<double> weights(static_cast<std::size_t>(elements));
  for (int n = 0; 2 * n < elements; ++n) {
    const double place = (n - (elements - 1) / 2.0) / elements;
    double sum = 1;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int m = static_cast<int>(i) + 1;
      sum += 2 * values[i] * std::cos(2 * kPi * m * place);
    }
    weights[n] = weights[elements - 1 - n] = sum / elements;
  }
  return weights;
}

}  // namespace ensonify
