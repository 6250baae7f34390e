#include "synthesis/cpu/spread_window.h"

#include <cmath>

#include "core/units.h"

namespace ensonify {

double window(double beta, double z) {
  const double inside = 1.0 - z * z;
  return inside > 0 ? std::exp(beta * (std::sqrt(inside) - 1.0)) : 0.0;
}

std::vector<double> transform_nodes(int width, int count) {
  std::vector<double> nodes(count);
  for (int i = 0; i < count; ++i) nodes[i] = kPi * width * std::sin(kPi / 2 * (i + 0.5) / count);
  return nodes;
}

std::vector<double> transform_weights(int width, double beta, int count) {
  std::vector<double> weights(count);
  for (int i = 0; i < count; ++i) {
    const double u = kPi / 2 * (i + 0.5) / count;
    weights[i] = window(beta, std::sin(u)) * std::cos(u) * (kPi / 2 / count) * width;
  }
  return weights;
}

WindowTransform::WindowTransform(int width, double beta, int nodes)
    : node_(transform_nodes(width, nodes)), weight_(transform_weights(width, beta, nodes)) {}

double WindowTransform::operator()(double x) const {
  double sum = 0;
  for (std::size_t i = 0; i < node_.size(); ++i) sum += weight_[i] * std::cos(node_[i] * x);
  return sum;
}

}  // namespace ensonify
