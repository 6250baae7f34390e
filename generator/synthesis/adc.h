// The receiver's converter.
#pragma once

#include <complex>
#include <span>

#include "core/sonar.h"

namespace ensonify {

// Real and imaginary part of each sample, each on its own: rounded to the nearest step (ties to
// even) of full scale / 2^(bits-1) and clipped to [-2^(bits-1), 2^(bits-1) - 1] steps.
void quantise(const Adc& adc, std::span<std::complex<float>> pressure_pa);

}  // namespace ensonify
