// The interface of the module: device programs on CUDA.
#include <cstdio>
#include <string>

#include "synthesis/cuda/cuda_queue.cuh"
#include "synthesis/cuda/device_backend.h"
#include "synthesis/cuda_backend.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

// "12.4" of 12040.
std::string release_name(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

int devices(CudaDevice* devices, int most, char* words, std::size_t size) {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error != cudaSuccess) {
    int has = 0;
    if (error == cudaErrorInsufficientDriver && cudaDriverGetVersion(&has) == cudaSuccess) {
      const std::string found = has == 0 ? "there is no driver"
                                         : "the driver is for CUDA " + release_name(has) +
                                               " or older";
      std::snprintf(words, size, "%s; expected one for CUDA %s or newer", found.c_str(),
                    release_name(CUDART_VERSION).c_str());
    } else {
      std::snprintf(words, size, "%s; expected a device that nvidia-smi lists",
                    cudaGetErrorString(error));
    }
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
                                           ensonify::share_planner, ensonify::make_backend};
  return &api;
}
