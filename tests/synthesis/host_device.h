// Backends whose device is the host. Their loops are compiled in host_device.cpp alone.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <utility>

#include "synthesis/cuda/device_backend.h"
#include "synthesis/host_queue.h"

namespace ensonify {

extern template class DeviceBackend<test::HostQueue>;
extern template class DeviceBackend<test::HostQueue, ArrayProgram<test::HostQueue>>;
extern template class ArrayProgram<test::HostQueue>;
extern template class ArrayPowerProgram<test::HostQueue>;

namespace test {

// For a DeviceBackend: `first` for its first lane, plain ones for those that it may open beside.
inline std::function<std::unique_ptr<HostQueue>()> queues_from(HostQueue* first) {
  auto next = std::make_shared<std::unique_ptr<HostQueue>>(first);
  return [next] { return *next ? std::move(*next) : std::make_unique<HostQueue>(); };
}

inline std::unique_ptr<Backend> host_device(const SynthesisSetup& setup,
                                            HostQueue* queue = new HostQueue()) {
  return make_device_backend<HostQueue>(queues_from(queue), setup);
}

}  // namespace test
}  // namespace ensonify
