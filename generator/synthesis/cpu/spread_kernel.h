// The kernel with which the fast path spreads echoes over the time grid, as narrow and the grid as
// short as an error allows.
#pragma once

#include <vector>

#include "synthesis/cpu/kernels.h"

namespace ensonify {

// ES kernel exp(beta (sqrt(1 - z^2) - 1)) on |z| <= 1, `width` points of a grid of `points` across.
struct SpreadKernel {
  int points = 0;
  int width = 0;
  double beta = 0;
  double alias_error = 0;          // relative L2 of an echo, worked out from the kernel's transform
  double rounding_gain = 0;        // by which a grid point's relative rounding grows in an echo
  std::vector<double> correction;  // [k = 0 .. highest]: 1 / transform of the kernel; even in k
  std::vector<float> coefficient;  // of its KernelPolynomial
  int degree = 0;

  KernelPolynomial polynomial() const { return {coefficient.data(), degree, (width + 7) / 8}; }
};

// For sums at |k| <= energy.size() - 1, energy[k] being what an echo has at +-k after filtering:
// what is filtered away may be wrong. The cheapest whose alias error is at most `tolerance` and
// whose rounding stays under it; points = 0: there is none.
SpreadKernel choose_spread_kernel(const std::vector<double>& energy, double tolerance);

}  // namespace ensonify
