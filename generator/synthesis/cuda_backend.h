// The CUDA backend, behind a module that is opened when it is first asked for.
//
//   CudaDeviceInfo  cuda_devices
//   make_cuda_backend
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "synthesis/backend.h"

namespace ensonify {

struct CudaDeviceInfo {
  int index = 0;
  std::string name;
  std::uint64_t memory_bytes = 0;
};

// At least one. Error (device): the program was built without CUDA, the module or a library that it
// needs is missing, it is of another build, or no device answers; with the system's or the driver's
// words. The module is libensonify_cuda.so by companion_path, or what ENSONIFY_CUDA_MODULE names.
Result<std::vector<CudaDeviceInfo>> cuda_devices();

// Series within 1e-4 of the CPU backend's (relative L2), whatever `tolerance`; the same bytes from
// run to run on the same device. May be called from several threads at once: what comes while the
// device is at work makes the next batch. Throws DeviceFailure where the device fails, or has no
// memory for a single ping. Error (device): as above.
Result<std::unique_ptr<Backend>> make_cuda_backend(const SynthesisSetup& setup, int device = 0);

}  // namespace ensonify
