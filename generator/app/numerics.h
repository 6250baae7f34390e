// What decides the last bits of a result on this machine.
#pragma once

#include <string>

namespace ensonify {

// The widest vector instructions that the processor offers ("avx512", "avx2", "sse2"): FFTW and
// the mathematical library choose their code by it.
std::string simd_level();

}  // namespace ensonify
