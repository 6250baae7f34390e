// The interface of the module: device programs on CUDA.
#include <cstdio>

#include "synthesis/cuda/cuda_queue.cuh"
#include "synthesis/cuda/device_backend.h"
#include "synthesis/cuda_backend.h"

namespace ensonify {
namespace {

int devices(CudaDevice* devices, int most, char* words, std::size_t size) {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error != cudaSuccess) {
    std::snprintf(words, size, "%s", cudaGetErrorString(error));
    return -1;
  }
  count = std::min(count, most);
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp properties{};
    if (cudaGetDeviceProperties(&properties, i) != cudaSuccess) return i;
    devices[i].index = i;
    std::snprintf(devices[i].name, sizeof devices[i].name, "%s", properties.name);
    devices[i].memory_bytes = properties.totalGlobalMem;
  }
  return count;
}

Backend* make_backend(const SynthesisSetup& setup, int device) {
  return make_device_backend<CudaQueue>([device] { return std::make_unique<CudaQueue>(device); },
                                        setup)
      .release();
}

}  // namespace
}  // namespace ensonify

extern "C" const ensonify::CudaModuleApi* ensonify_cuda_module() {
  static const ensonify::CudaModuleApi api{ensonify::cuda_module_identity(), ensonify::devices,
                                           ensonify::make_backend};
  return &api;
}
