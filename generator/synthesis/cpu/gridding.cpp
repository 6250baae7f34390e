#include "synthesis/cpu/gridding.h"

#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr int kWidth = 16;
constexpr double kBetaPerPoint = 2.30;  // the paper's choice at twofold oversampling

template <class Value>
void spread_value(const GriddingKernel& kernel, double x, Value value, Value* grid) {
  const double centre = (x - std::floor(x)) * kernel.grid;
  const double half = kernel.width / 2.0;
  const int first = static_cast<int>(std::ceil(centre - half));
  for (int l = first; l < first + kernel.width; ++l) {
    const int wrapped = l < 0 ? l + kernel.grid : (l >= kernel.grid ? l - kernel.grid : l);
    grid[wrapped] += window(kernel.beta, (l - centre) / half) * value;
  }
}

}  // namespace

double window(double beta, double z) {
  const double inside = 1.0 - z * z;
  return inside > 0 ? std::exp(beta * (std::sqrt(inside) - 1.0)) : 0.0;
}

WindowIntegral::WindowIntegral(double beta, int width, int places) {
  for (int i = 0; i < places; ++i) {
    const double u = kPi * ((i + 0.5) / places - 0.5);
    const double z = std::sin(u);
    z_.push_back(z);
    weight_.push_back(window(beta, z) * std::cos(u) * (kPi / places) * width / 2.0);
  }
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

GriddingKernel make_gridding_kernel(int grid, int highest) {
  ENSONIFY_ASSERT(grid >= 4 * highest && grid > kWidth);
  GriddingKernel kernel{grid, kWidth, kBetaPerPoint * kWidth, {}};
  kernel.correction.resize(highest + 1);
  const WindowIntegral transform(kernel.beta, kernel.width, 400);
  for (int k = 0; k <= highest; ++k) {
    kernel.correction[k] =
        1.0 / transform([&](double z) { return kPi * k * kernel.width * z / grid; });
  }
  return kernel;
}

void spread(const GriddingKernel& kernel, double x, std::complex<double> value,
            std::complex<double>* grid) {
  spread_value(kernel, x, value, grid);
}

void spread(const GriddingKernel& kernel, double x, double value, double* grid) {
  spread_value(kernel, x, value, grid);
}

}  // namespace ensonify
