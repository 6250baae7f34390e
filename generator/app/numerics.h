// What decides the last bits of a result on this machine.
#pragma once

#include <string>

#include "core/simd.h"

namespace ensonify {

// The level that the program's own loops use and, where it is another, what the processor offers:
// FFTW and the mathematical library choose their code by that ("avx512", "sse4 on avx512").
std::string numerics_name(SimdLevel used);

}  // namespace ensonify
