// Between the program and the module that holds CUDA, which is opened at run time: a program on a
// machine without CUDA's libraries starts all the same.
#pragma once

#include <cstddef>

#include "synthesis/backend.h"

namespace ensonify {

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
