// Spreading over a grid by a compact window, for type-1 nonuniform FFTs in one dimension: sums of
// phasors at uniform frequencies from samples at arbitrary times.
//
// The window is exp(beta (sqrt(1 - z^2) - 1)), z = -1 ... 1 over its `width` grid steps: Barnett,
// Magland and af Klinteberg, "A parallel nonuniform fast Fourier transform library based on an
// 'exponential of semicircle' kernel" (SISC 2019).
//
//   window
//   WindowIntegral                  its Fourier transform, for any phase
//   transform_nodes  transform_weights  WindowTransform   the same for linear phases
//   GriddingKernel  make_gridding_kernel   the window and the correction that undoes it
//   spread                          adds one sample to the grid
#pragma once

#include <cmath>
#include <complex>
#include <vector>

namespace ensonify {

// The window at z; 0 for |z| > 1.
double window(double beta, double z);

// (width / 2) times the integral of window(z) cos(phase(z)) over z = -1 ... 1. With z = sin u, the
// integrand is smooth and almost zero at both ends, so that the trapezoid rule converges
// geometrically.
class WindowIntegral {
 public:
  WindowIntegral(double beta, int width, int places);

  // The phase is phase_rad(z), in radians.
  template <class Phase>
  double operator()(const Phase& phase_rad) const {
    double sum = 0;
    for (std::size_t i = 0; i < z_.size(); ++i) sum += weight_[i] * std::cos(phase_rad(z_[i]));
    return sum;
  }

 private:
  std::vector<double> z_, weight_;
};

// The window's Fourier transform at x periods per grid step is the sum of weight * cos(node * x).
std::vector<double> transform_nodes(int width, int count);
std::vector<double> transform_weights(int width, double beta, int count);

class WindowTransform {
 public:
  WindowTransform(int width, double beta, int nodes);
  double operator()(double x) const;

 private:
  std::vector<double> node_, weight_;
};

// The window has a width of 16 at twofold oversampling. Its error is less than 1e-14 of the sum of
// magnitudes.
struct GriddingKernel {
  int grid = 0;   // fine grid points in the period
  int width = 0;  // points that one sample reaches
  double beta = 0;
  std::vector<double> correction;  // [k = 0 .. highest]: 1 / transform of the kernel; even in k
};

// `highest` is the largest |k| that is needed. The stated error needs grid >= 4 highest.
GriddingKernel make_gridding_kernel(int grid, int highest);

// Adds value times the kernel at position x (in periods, any real number) to grid[kernel.grid].
// Then sum_i v_i e^(-i 2 pi k x_i) = correction[|k|] sum_l grid[l] e^(-i 2 pi k l / grid points).
void spread(const GriddingKernel& kernel, double x, std::complex<double> value,
            std::complex<double>* grid);
void spread(const GriddingKernel& kernel, double x, double value, double* grid);

}  // namespace ensonify
