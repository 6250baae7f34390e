// Type-1 nonuniform FFT in one dimension: sums of phasors at uniform frequencies from samples at
// any times, by spreading each sample over a fine grid with a compact kernel.
//
//   GriddingKernel        the spreading window and its correction
//   make_gridding_kernel
//   spread                one sample onto the grid
#pragma once

#include <complex>
#include <vector>

namespace ensonify {

// exp(beta (sqrt(1 - z^2) - 1)) on |z| <= 1, `width` grid points across; Barnett, Magland and
// af Klinteberg, "A parallel nonuniform fast Fourier transform library based on an 'exponential of
// semicircle' kernel" (SISC 2019). Width 16 at twofold oversampling leaves less than 1e-14 of the
// sum of magnitudes.
struct GriddingKernel {
  int grid = 0;   // fine grid points in the period
  int width = 0;  // points that one sample reaches
  double beta = 0;
  std::vector<double> correction;  // [k = 0 .. highest]: 1 / transform of the kernel; even in k
};

// `highest` is the largest |k| wanted; grid >= 4 highest keeps the stated error.
GriddingKernel make_gridding_kernel(int grid, int highest);

// Adds value times the kernel at position x (in periods, any real number) to grid[kernel.grid].
// Then sum_i v_i e^(-i 2 pi k x_i) = correction[|k|] sum_l grid[l] e^(-i 2 pi k l / grid points).
void spread(const GriddingKernel& kernel, double x, std::complex<double> value,
            std::complex<double>* grid);
void spread(const GriddingKernel& kernel, double x, double value, double* grid);

}  // namespace ensonify
