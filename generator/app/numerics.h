// What decides the last bits of a result on this machine.
//
//   BackendChoice  Numerics
//   settle_backend  make_backend
//   numerics_name
#pragma once

#include <memory>
#include <string>

#include "core/error.h"
#include "core/simd.h"
#include "synthesis/backend.h"

namespace ensonify {

enum class BackendChoice { automatic, cpu, cuda, reference };

class TableCache;

struct Numerics {
  BackendChoice backend = BackendChoice::cpu;
  SimdLevel simd = best_simd_level();
  std::string backend_name = "cpu";  // as work.json has it; with the device's name behind cuda
  std::shared_ptr<TableCache> tables = {};  // of several runs (tables.h)
};

// `automatic` becomes cuda where a device answers, else cpu. Error (device): cuda is asked for, and
// none answers.
Result<Numerics> settle_backend(BackendChoice choice, SimdLevel simd);

// `numerics` settled. Throws DeviceFailure where the device cannot be had any more.
std::unique_ptr<Backend> make_backend(const Numerics& numerics, const SynthesisSetup& setup);

// The level that the program's own loops use and, where it is another, what the processor offers:
// FFTW and the mathematical library choose their code by that ("avx512", "sse4 on avx512").
std::string numerics_name(SimdLevel used);

}  // namespace ensonify
