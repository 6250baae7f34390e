// The envelope of a pulse between the samples, without a transform library.
//
//   envelope_squared
#pragma once

#include <complex>
#include <vector>

namespace ensonify {

// |s(t)|^2 of s(t) = sum_m S_m e^(i 2 pi (m - M/2)(b/M) t) at t = k / (oversampling b),
// k = 0 .. oversampling M - 1. Quick where M, the number of bins, has small prime factors alone.
std::vector<double> envelope_squared(const std::vector<std::complex<double>>& spectrum,
                                     int oversampling);

}  // namespace ensonify
