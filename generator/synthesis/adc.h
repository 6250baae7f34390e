// The receiver's ADC.
//
//   quantise   rounds and clips a time series
//   Converter  converter_of  converted   the same for one part of one sample, on host or device
#pragma once

#include <cmath>
#include <complex>
#include <span>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/sonar.h"

namespace ensonify {

struct Converter {
  double step_pa, steps;  // steps from zero to full scale
};

inline Converter converter_of(const Adc& adc) {
  ENSONIFY_ASSERT(adc.bits >= 1);
  const double steps = std::ldexp(1.0, adc.bits - 1);
  return {std::pow(10.0, (adc.full_scale_db - 120.0) / 20.0) / steps, steps};
}

// One part of a sample in Pa, rounded to the nearest step (ties to even) and clipped.
ENSONIFY_HD inline float converted(const Converter& converter, float part_pa) {
  const double step = std::nearbyint(part_pa / converter.step_pa);
  const double least = -converter.steps, most = converter.steps - 1;
  return static_cast<float>((step < least ? least : step > most ? most : step) * converter.step_pa);
}

// Rounds the real and the imaginary part of each sample separately to the nearest step (ties to
// even) of full scale / 2^(bits-1), and clips them to [-2^(bits-1), 2^(bits-1) - 1] steps.
inline void quantise(const Adc& adc, std::span<std::complex<float>> pressure_pa) {
  const Converter converter = converter_of(adc);
  for (std::complex<float>& p : pressure_pa) {
    p = {converted(converter, p.real()), converted(converter, p.imag())};
  }
}

}  // namespace ensonify
