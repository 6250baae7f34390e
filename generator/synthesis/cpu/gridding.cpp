#include "synthesis/cpu/gridding.h"

#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "synthesis/cpu/spread_window.h"

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

GriddingKernel make_gridding_kernel(int grid, int highest) {
  ENSONIFY_ASSERT(grid >= 4 * highest && grid > kWidth);
  GriddingKernel kernel{grid, kWidth, kBetaPerPoint * kWidth, {}};
  kernel.correction.resize(highest + 1);
  // Transform of the window in grid steps, (w/2) int_{-1}^{1} window(z) cos(pi k w z / grid) dz.
  // With z = sin(u) the integrand is smooth and vanishes to all useful digits at both ends, so
  // that the trapezoid rule converges geometrically.
  constexpr int kNodes = 400;
  std::vector<double> node(kNodes), weight(kNodes);
  for (int i = 0; i < kNodes; ++i) {
    const double u = kPi * ((i + 0.5) / kNodes - 0.5);
    node[i] = std::sin(u);
    weight[i] = window(kernel.beta, node[i]) * std::cos(u) * (kPi / kNodes) * kernel.width / 2.0;
  }
  for (int k = 0; k <= highest; ++k) {
    double sum = 0;
    for (int i = 0; i < kNodes; ++i) {
      sum += weight[i] * std::cos(kPi * k * kernel.width * node[i] / grid);
    }
    kernel.correction[k] = 1.0 / sum;
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
