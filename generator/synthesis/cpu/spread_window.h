// The window that an echo is spread by (Barnett, Magland, af Klinteberg 2019): exp(beta (sqrt(1 -
// z^2)
// - 1)), z = -1 ... 1 over its `width` grid steps.
//
//   window
//   transform_nodes  transform_weights  WindowTransform   its Fourier transform
#pragma once

#include <vector>

namespace ensonify {

// 0 beyond its ends.
double window(double beta, double z);

// The window's Fourier transform at x periods a grid step is the sum of weight * cos(node * x).
// With z = sin u the integrand is smooth and all but vanishes at both ends: the trapezoid rule
// converges fast.
std::vector<double> transform_nodes(int width, int count);
std::vector<double> transform_weights(int width, double beta, int count);

class WindowTransform {
 public:
  WindowTransform(int width, double beta, int nodes);
  double operator()(double x) const;

 private:
  std::vector<double> node_, weight_;
};

}  // namespace ensonify
