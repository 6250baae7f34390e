// A module as the CUDA module is, whose device is the host: the program's tests open it in place of
// that one, so that everything but CUDA's own calls runs where there is no device.
//
// ENSONIFY_HOST_DEVICE, words in any order: limit=BYTES of memory, free=BYTES that it reports as
// free, lost_after=LAUNCHES, devices=NUMBER, none (no device answers).
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include "core/error.h"
#include "synthesis/cuda_backend.h"
#include "synthesis/fft.h"
#include "synthesis/host_device.h"

namespace ensonify {
namespace {

using test::HostQueue;

std::string told() {
  const char* words = std::getenv("ENSONIFY_HOST_DEVICE");
  return words == nullptr ? "" : words;
}

std::size_t number(const std::string& key, std::size_t otherwise) {
  const std::string words = told();
  const std::size_t at = words.find(key + "=");
  return at == std::string::npos ? otherwise : std::stoull(words.substr(at + key.size() + 1));
}

int devices(CudaDevice* devices, int, char* words, std::size_t size) {
  if (told() == "none") {
    std::snprintf(words, size, "no CUDA-capable device is detected; expected one");
    return -1;
  }
  const int count = static_cast<int>(number("devices", 1));
  for (int i = 0; i < count; ++i) {
    std::snprintf(devices[i].name, sizeof devices[i].name, "the host itself");
    devices[i].index = i;
    devices[i].memory_bytes = number("limit", std::size_t{1} << 40);
  }
  return count;
}

std::unique_ptr<HostQueue> make_queue() {
  auto queue = std::make_unique<HostQueue>(number("limit", std::size_t{1} << 40),
                                           number("free", std::size_t{1} << 40));
  queue->lost_after = static_cast<int>(number("lost_after", std::numeric_limits<int>::max()));
  return queue;
}

// Two planners of FFTW at once would destroy its state.
bool has_planner = false;

void share(std::mutex& mutex) {
  has_planner = true;
  share_planner(mutex);
}

Backend* make_backend(const SynthesisSetup& setup, int) {
  ENSONIFY_ASSERT(has_planner);
  return make_device_backend<HostQueue>(make_queue, setup).release();
}

}  // namespace
}  // namespace ensonify

extern "C" const ensonify::CudaModuleApi* ensonify_cuda_module() {
  static const ensonify::CudaModuleApi api{ensonify::cuda_module_identity(), ensonify::devices,
                                           ensonify::share, ensonify::make_backend};
  return &api;
}
