#include "synthesis/cuda_backend.h"

#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "core/moments.h"
#include "core/runtime.h"

namespace ensonify {
namespace {

constexpr int kMostDevices = 64;

const char* given_module() { return std::getenv("ENSONIFY_CUDA_MODULE"); }

std::filesystem::path module_path() {
  if (const char* given = given_module()) return given;
  return companion_path("libensonify_cuda.so");
}

Error missing(const std::string& trouble) { return {ErrorKind::device, "CUDA: " + trouble}; }

Result<const CudaModuleApi*> open_module() {
  const std::filesystem::path path = module_path();
  if (!std::filesystem::exists(path)) {
    return missing("there is no " + path.string() +
                   "; the program was built without a CUDA compiler, or its module is missing");
  }
  const Result<void*> entry =
      module_symbol(path, kCudaModuleEntry, "expected cuFFT of CUDA 12 or newer");
  if (!entry) return missing(entry.error().message);
  const CudaModuleApi* api = reinterpret_cast<CudaModuleEntry>(*entry)();
  if (std::strcmp(api->built_from, cuda_module_identity()) != 0) {
    return missing(path.string() + " was built from another version (" + api->built_from +
                   ") than the program (" + cuda_module_identity() + ")");
  }
  return api;
}

const Result<const CudaModuleApi*>& opened_module() {
  static const Result<const CudaModuleApi*> module = open_module();
  return module;
}

}  // namespace

const char* cuda_module_identity() {
  static const std::string identity =
      std::string(ENSONIFY_VERSION ", " __VERSION__ ", ") + std::to_string(sizeof(SynthesisSetup)) +
      " " + std::to_string(sizeof(PingTask)) + " " + std::to_string(sizeof(PingSeries)) + " " +
      std::to_string(sizeof(Scatterer)) + " " + std::to_string(sizeof(VolumeEcho)) + " " +
      std::to_string(sizeof(Moments)) + " " + std::to_string(sizeof(PooledPixels));
  return identity.c_str();
}

bool may_have_cuda_device() {
  // The driver's own library, which belongs to no toolkit. It stays open for the module.
  return given_module() != nullptr || dlopen("libcuda.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr;
}

Result<std::vector<CudaDeviceInfo>> cuda_devices() {
  const Result<const CudaModuleApi*>& module = opened_module();
  if (!module) return module.error();
  std::vector<CudaDevice> found(kMostDevices);
  char words[512] = "";
  const int count = (*module)->devices(found.data(), kMostDevices, words, sizeof words);
  if (count < 0) return missing(words);
  if (count == 0) return missing("the driver reports no device");
  std::vector<CudaDeviceInfo> devices;
  for (int i = 0; i < count; ++i) {
    devices.push_back({found[i].index, found[i].name, found[i].memory_bytes});
  }
  return devices;
}

Result<std::unique_ptr<Backend>> make_cuda_backend(const SynthesisSetup& setup, int device) {
  const Result<std::vector<CudaDeviceInfo>> devices = cuda_devices();
  if (!devices) return devices.error();
  return std::unique_ptr<Backend>((*opened_module())->make_backend(setup, device));
}

}  // namespace ensonify
