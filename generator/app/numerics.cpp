#include "app/numerics.h"

#include "synthesis/cuda_backend.h"

namespace ensonify {

Result<Numerics> settle_backend(BackendChoice choice, SimdLevel simd) {
  if (choice == BackendChoice::cpu) return Numerics{choice, simd, "cpu"};
  if (choice == BackendChoice::reference) return Numerics{choice, simd, "reference"};
  const Result<std::vector<CudaDeviceInfo>> devices = cuda_devices();
  if (devices) return Numerics{BackendChoice::cuda, simd, "cuda, " + devices->front().name};
  if (choice == BackendChoice::cuda) return devices.error();
  return Numerics{BackendChoice::cpu, simd, "cpu"};
}

std::unique_ptr<Backend> make_backend(const Numerics& numerics, const SynthesisSetup& setup) {
  ENSONIFY_ASSERT(numerics.backend != BackendChoice::automatic);
  if (numerics.backend == BackendChoice::reference) return make_reference_backend(setup);
  if (numerics.backend == BackendChoice::cpu) return make_cpu_backend(setup);
  Result<std::unique_ptr<Backend>> backend = make_cuda_backend(setup);
  if (!backend) throw DeviceFailure(backend.error().message);
  return std::move(*backend);
}

std::string numerics_name(SimdLevel used) {
  std::string name(simd_level_name(used));
  if (used != best_simd_level()) {
    name += " on " + std::string(simd_level_name(best_simd_level()));
  }
  return name;
}

}  // namespace ensonify
