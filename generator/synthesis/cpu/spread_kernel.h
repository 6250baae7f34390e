// The kernel with which the fast path spreads echoes over the time grid. Kernel and grid are as
// short as the tolerance allows.
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
  double alias_error = 0;          // relative L2 error of an echo, from the kernel's transform
  double rounding_gain = 0;        // relative error of an echo per relative rounding of grid points
  std::vector<double> correction;  // [k = 0 .. highest]: 1 / transform of the kernel; even in k
  std::vector<float> coefficient;  // of its KernelPolynomial
  int degree = 0;

  KernelPolynomial polynomial() const { return {coefficient.data(), degree, (width + 3) / 4}; }
};

// The kernel of least cost for sums at k = first, first + 1 ... that are then multiplied by
// `spectrum`, so that errors where `spectrum` is small do not matter. The relative L2 error of an
// echo is at most `tolerance`, and at most ten times this in any tail of the echo that has 1e-6 of
// its norm. Rounding stays below `tolerance` too. Only widths up to `widest` are tried. points = 0
// if there is no such kernel.
SpreadKernel choose_spread_kernel(const std::vector<std::complex<double>>& spectrum, int first,
                                  double tolerance, int widest = 14);

// Polynomials of the same kernel for offsets up to `reach` instead of 1. Echoes whose kernels begin
// up to (reach - 1)/2 points away from `first` can then share one place. The variable is
// x = offset / reach. Point l is even + odd, and point width - 1 - l is even - odd.
struct WidePolynomials {
  int terms = 0;                   // of even and odd each: 1, x^2, x^4 ...; odd is multiplied by x
  std::vector<float> coefficient;  // [ceil(width / 2)][terms][even, odd], highest power first
};
WidePolynomials fit_wide(const SpreadKernel& kernel, double reach, double tolerance);

// Rms of the loss in such echoes where the end of the kernel lies beyond the polynomials' points.
double lost_beyond(const SpreadKernel& kernel, double reach);

}  // namespace ensonify
