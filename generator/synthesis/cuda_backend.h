// The CUDA backend, behind a module that is opened when it is first asked for: a program on a
// machine without CUDA's libraries starts all the same.
//
//   CudaDeviceInfo  cuda_devices
//   make_cuda_backend
//   CudaModuleApi  cuda_module_identity   between the program and the module
#pragma once

#include <cstddef>
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

struct CudaDevice {
  int index;
  char name[256];
  std::uint64_t memory_bytes;
};

// Both are built together: what the other side was built from is compared before anything is
// called.
struct CudaModuleApi {
  const char* built_from;  // cuda_module_identity()
  // Devices, at most `most`; their number. Below 0: none answers, and `words` is what the driver
  // says.
  int (*devices)(CudaDevice* devices, int most, char* words, std::size_t size);
  // Throws std::bad_alloc and DeviceFailure. To be deleted by the caller.
  Backend* (*make_backend)(const SynthesisSetup& setup, int device);
};

inline constexpr char kCudaModuleEntry[] = "ensonify_cuda_module";
using CudaModuleEntry = const CudaModuleApi* (*)();

// Compiler, and sizes of what crosses the border.
const char* cuda_module_identity();

}  // namespace ensonify
