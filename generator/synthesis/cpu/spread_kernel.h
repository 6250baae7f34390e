// The kernel with which the fast path spreads echoes over the time grid, as narrow and the grid as
// short as an error allows.
#pragma once

#include <complex>
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

  KernelPolynomial polynomial() const { return {coefficient.data(), degree, (width + 3) / 4}; }
};

// For sums at k = first, first + 1 ... that are then multiplied by `spectrum`: what is filtered
// away may be wrong. The cheapest kernel with which an echo's relative L2 error is at most
// `tolerance`, and ten times that in any tail of it that holds 1e-6 of its norm; rounding stays
// under it too. Kernels wider than `widest` are not tried. points = 0: there is none.
SpreadKernel choose_spread_kernel(const std::vector<std::complex<double>>& spectrum, int first,
                                  double tolerance, int widest = 14);

// The same kernel's polynomials where they are asked up to `reach` instead of 1, so that echoes
// that begin up to (reach - 1)/2 points beside `first` need no place of their own. They are in
// x = offset / reach; of points l and width - 1 - l one is even + odd and one even - odd.
struct WidePolynomials {
  int terms = 0;                   // of even and of odd each: 1, x^2, x^4 ...; odd times x
  std::vector<float> coefficient;  // [ceil(width / 2)][terms][even, odd], highest power first
};
WidePolynomials fit_wide(const SpreadKernel& kernel, double reach, double tolerance);

// Rms of what such echoes lose, their kernel's end lying where the polynomials have no point.
double lost_beyond(const SpreadKernel& kernel, double reach);

}  // namespace ensonify
