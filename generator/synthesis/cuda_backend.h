// The CUDA backend. It is in a module that is loaded at the first request, so that the program
// also starts on a machine without CUDA's libraries.
//
//   may_have_cuda_device     without loading the module
//   CudaDeviceInfo  cuda_devices
//   MakeBackend  make_shared_backend   several devices as one
//   make_cuda_backend  kEnsembleHostBytes
//   CudaModuleApi  cuda_module_identity   between the program and the module
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/error.h"
#include "synthesis/backend.h"

namespace ensonify {

// False if this machine has no driver of CUDA devices, or none that the system finds. True does not
// promise a device. CUDA's libraries take longer to load than a small scene.
bool may_have_cuda_device();

struct CudaDeviceInfo {
  int index = 0;
  std::string name;
  std::uint64_t memory_bytes = 0;
};

// At least one device. Error (device), with the message of the system or the driver: the program
// was built without CUDA, the module or a library that it needs is missing, the module belongs to
// another build, the driver is too old, or no device responds. The module is libensonify_cuda.so at
// companion_path, or the file that ENSONIFY_CUDA_MODULE names.
Result<std::vector<CudaDeviceInfo>> cuda_devices();

using MakeBackend = std::function<std::unique_ptr<Backend>()>;

// A backend for several devices that make the same bytes. The first is made at once, the others
// when requests wait. A device that fails or lacks memory is left out as long as there is another.
std::unique_ptr<Backend> make_shared_backend(std::vector<MakeBackend> makers);

// A backend for the first device and all that have its name. Time series within 1e-4 of those of
// the CPU backend (relative L2) for any `tolerance`, and the same bytes in every run on devices of
// one name. Several threads may call it at once: requests that arrive while the device is busy form
// the next batch. Throws DeviceFailure if the device fails or has no memory for a single ping.
// Error (device): as above, or no memory for the tables.
Result<std::unique_ptr<Backend>> make_cuda_backend(const SynthesisSetup& setup);

// Host memory for a batch of an ensemble, unless a block of realizations needs more.
inline constexpr std::uint64_t kEnsembleHostBytes = 32'000'000;

struct CudaDevice {
  int index;
  char name[256];
  std::uint64_t memory_bytes;
};

// Program and module must be built together. The program compares `built_from` with its own
// identity before it calls anything.
struct CudaModuleApi {
  const char* built_from;  // cuda_module_identity()
  // Fills in at most `most` devices and returns their number. Below 0: no device responds, and
  // `words` is the driver's message.
  int (*devices)(CudaDevice* devices, int most, char* words, std::size_t size);
  // Called before make_backend, with planner_mutex() of the program.
  void (*share_planner)(std::mutex& mutex);
  // Throws std::bad_alloc and DeviceFailure. The caller deletes the backend.
  Backend* (*make_backend)(const SynthesisSetup& setup, int device);
};

inline constexpr char kCudaModuleEntry[] = "ensonify_cuda_module";
using CudaModuleEntry = const CudaModuleApi* (*)();

// The compiler, and the sizes of the types that program and module exchange.
const char* cuda_module_identity();

}  // namespace ensonify
