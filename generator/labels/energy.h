// What an echo counts in labels.
#pragma once

#include <complex>

#include "core/scatterers.h"

namespace ensonify {

// E|a|^2 gain^2, 1/m^2.
inline double expected_energy(const Scatterer& s) {
  const double square = std::norm(std::complex<double>(s.mean)) +
                        static_cast<double>(s.standard_deviation) * s.standard_deviation;
  return square * s.gain * s.gain;
}

}  // namespace ensonify
