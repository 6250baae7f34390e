// Fourier sums over powers of two. Private to world/: small and plain, so that terrain is the same
// bits on every processor and no planner is shared with the synthesis.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

namespace ensonify {

// x[j] = sum over k of X[k] exp(+2 pi i j k / n), not normalised, in place.
class FourierSum {
 public:
  explicit FourierSum(std::size_t length);  // a power of two
  void run(std::complex<double>* data) const;

 private:
  std::vector<std::complex<double>> turns_;  // exp(2 pi i j / n), j < n / 2
  std::vector<std::uint32_t> reversed_;      // indices with their bits in reverse order
};

}  // namespace ensonify
