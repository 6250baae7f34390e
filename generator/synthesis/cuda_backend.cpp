#include "synthesis/cuda_backend.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <new>
#include <utility>

#include "core/moments.h"
#include "core/runtime.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

constexpr int kMostDevices = 64;

const char* given_module() { return std::getenv("ENSONIFY_CUDA_MODULE"); }

std::filesystem::path module_path() {
  if (const char* given = given_module()) return given;
  return companion_path("libensonify_cuda.so");
}

// `trouble` ends with what would be right.
Error missing(const std::string& trouble) {
  return {ErrorKind::device, "CUDA: " + trouble + ", or --backend cpu"};
}

Result<const CudaModuleApi*> open_module() {
  const std::filesystem::path path = module_path();
  if (!std::filesystem::exists(path)) {
    return missing("there is no " + path.string() +
                   "; expected a program that was built with a CUDA compiler, with its module");
  }
  const Result<void*> entry = module_symbol(
      path, kCudaModuleEntry, "expected the program's module, and cuFFT of CUDA 12 or newer");
  if (!entry) return missing(entry.error().message);
  const CudaModuleApi* api = reinterpret_cast<CudaModuleEntry>(*entry)();
  if (std::strcmp(api->built_from, cuda_module_identity()) != 0) {
    return missing(path.string() + " was built from another version (" + api->built_from +
                   ") than the program (" + cuda_module_identity() +
                   "); expected both from one build");
  }
  api->share_planner(planner_mutex());
  return api;
}

const Result<const CudaModuleApi*>& opened_module() {
  static const Result<const CudaModuleApi*> module = open_module();
  return module;
}

// Sends each request to the device that has the fewest.
class SharedDevices final : public Backend {
 public:
  explicit SharedDevices(std::vector<MakeBackend> makers) {
    for (MakeBackend& make : makers) {
      devices_.push_back(std::make_unique<Device>());
      devices_.back()->make = std::move(make);
    }
    devices_.front()->backend = devices_.front()->make();
  }

  SynthesisMemory memory(bool has_volumes) const override { return first().memory(has_volumes); }
  int draws_at_once() const override { return first().draws_at_once(); }
  std::uint64_t missing_bytes(std::uint64_t scatterers, bool has_volumes) const override {
    return first().missing_bytes(scatterers, has_volumes);
  }

  // A device that fails is left out as long as there is another: results do not depend on the
  // device.
  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    for (;;) {
      Device& device = taken();
      try {
        made(device).synthesize(tasks, series, workers);
        return give_back(device);
      } catch (const DeviceFailure&) {
        if (!leaves_out(device)) throw;
      } catch (const std::bad_alloc&) {
        if (!leaves_out(device)) throw;
      }
    }
  }

  std::unique_ptr<MomentSums> moment_sums(const Moments& moments,
                                          const PooledPixels& pool) const override {
    Device& device = taken();
    auto held = std::make_unique<HeldSums>(*this, device);
    held->sums = made(device).moment_sums(moments, pool);
    if (!held->sums) return nullptr;
    return held;
  }

 private:
  struct Device {
    MakeBackend make;
    std::mutex making;
    std::unique_ptr<Backend> backend;  // made when it is first needed
    int requests = 0;
    bool is_left_out = false;
  };

  // The sums of one device, which count as a request of it as long as they live.
  struct HeldSums final : MomentSums {
    HeldSums(const SharedDevices& owner, Device& device) : shared(owner), from(device) {}
    ~HeldSums() override {
      sums.reset();
      shared.give_back(from);
    }
    std::size_t add(std::span<const PingTask> tasks, const Workers& workers) override {
      return sums->add(tasks, workers);
    }
    void read(Moments& moments) override { sums->read(moments); }

    const SharedDevices& shared;
    Device& from;
    std::unique_ptr<MomentSums> sums;
  };

  const Backend& first() const { return *devices_.front()->backend; }

  Device& taken() const {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::min_element(devices_, {}, [](const auto& device) {
      return std::pair(device->is_left_out, device->requests);
    });
    ++(*found)->requests;
    return **found;
  }

  static const Backend& made(Device& device) {
    const std::lock_guard lock(device.making);
    if (!device.backend) device.backend = device.make();
    return *device.backend;
  }

  void give_back(Device& device) const {
    const std::lock_guard lock(mutex_);
    --device.requests;
  }

  // False if it is the last one.
  bool leaves_out(Device& device) const {
    const std::lock_guard lock(mutex_);
    --device.requests;
    const auto left =
        std::ranges::count(devices_, false, [](const auto& other) { return other->is_left_out; });
    if (!device.is_left_out && left == 1) return false;
    device.is_left_out = true;
    return true;
  }

  mutable std::mutex mutex_;  // protects `requests` and `is_left_out`
  std::vector<std::unique_ptr<Device>> devices_;
};

}  // namespace

const char* cuda_module_identity() {
  static const std::string identity =
      std::string(ENSONIFY_VERSION ", " __VERSION__ ", ") + std::to_string(sizeof(SynthesisSetup)) +
      " " + std::to_string(sizeof(PingTask)) + " " + std::to_string(sizeof(PingSeries)) + " " +
      std::to_string(sizeof(Scatterer)) + " " + std::to_string(sizeof(VolumeEcho)) + " " +
      std::to_string(sizeof(Moments)) + " " + std::to_string(sizeof(PooledPixels)) + " " +
      std::to_string(sizeof(CudaModuleApi));
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
  if (count == 0) return missing("the driver reports no device; expected one");
  std::vector<CudaDeviceInfo> devices;
  for (int i = 0; i < count; ++i) {
    devices.push_back({found[i].index, found[i].name, found[i].memory_bytes});
  }
  return devices;
}

std::unique_ptr<Backend> make_shared_backend(std::vector<MakeBackend> makers) {
  return std::make_unique<SharedDevices>(std::move(makers));
}

Result<std::unique_ptr<Backend>> make_cuda_backend(const SynthesisSetup& setup) {
  const Result<std::vector<CudaDeviceInfo>> devices = cuda_devices();
  if (!devices) return devices.error();
  std::vector<MakeBackend> makers;
  for (const CudaDeviceInfo& device : *devices) {
    if (device.name != devices->front().name) continue;
    makers.emplace_back([setup, index = device.index] {
      return std::unique_ptr<Backend>((*opened_module())->make_backend(setup, index));
    });
  }
  try {
    return makers.size() == 1 ? makers.front()() : make_shared_backend(std::move(makers));
  } catch (const std::bad_alloc&) {
    return missing("not enough memory on " + devices->front().name +
                   " for the tables of this sonar; expected fewer beams or a shorter range");
  }
}

}  // namespace ensonify
