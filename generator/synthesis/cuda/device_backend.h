// The backend around a device program: batches that fit, results back to the host.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <span>

#include "core/error.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/array_batch.h"
#include "synthesis/cuda/array_program.h"
#include "synthesis/cuda/beam_program.h"

namespace ensonify {

// Of the free memory, what a batch may take; the rest is for transforms' own.
inline constexpr double kBatchShare = 0.6;
inline constexpr std::size_t kMostPings = 64;

template <class Queue, class Program = BeamProgram<Queue>>
class DeviceBackend final : public Backend {
 public:
  DeviceBackend(std::unique_ptr<Queue> queue, const SynthesisSetup& setup)
      : queue_(std::move(queue)), setup_(setup), program_(*queue_, setup) {}

  // On the host.
  SynthesisMemory memory(bool has_volumes) const override {
    SynthesisMemory memory;
    const std::uint64_t cells = std::uint64_t(setup_.sonar.beam_count) * setup_.record.samples;
    memory.ping_bytes = has_volumes ? cells * sizeof(float) : 0;
    memory.echo_bytes = sizeof(EchoRecord) + sizeof(std::uint32_t);
    if (setup_.sonar.array) memory.echo_bytes += array_echo_bytes();
    return memory;
  }

  // One caller at a time: there is one device.
  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    const std::lock_guard lock(mutex_);
    std::size_t most = kMostPings;
    for (std::size_t first = 0; first < tasks.size();) {
      const std::size_t count = std::min(fitting(tasks.subspan(first)), most);
      try {
        run_batch(tasks.subspan(first, count), series.subspan(first, count), workers);
      } catch (const std::bad_alloc&) {
        if (count == 1) throw;
        most = count / 2;
        continue;
      }
      first += count;
    }
  }

 private:
  // At least one.
  std::size_t fitting(std::span<const PingTask> tasks) const {
    const double free = kBatchShare * static_cast<double>(queue_->free_bytes());
    double bytes = 0;
    std::size_t count = 0;
    for (const PingTask& task : tasks) {
      bytes +=
          static_cast<double>(program_.ping_bytes(task.scatterers->size(), !task.volumes.empty()));
      if (count > 0 && bytes > free) break;
      ++count;
    }
    return count;
  }

  void run_batch(std::span<const PingTask> tasks, std::span<PingSeries> series,
                 const Workers& workers) const {
    fill_batch(setup_, tasks, workers, batch_);
    program_.run(batch_);
    const std::size_t cells = std::size_t(setup_.sonar.beam_count) * setup_.record.samples;
    for (std::size_t p = 0; p < tasks.size(); ++p) {
      series[p].pressure_pa.resize(cells);
      queue_->download(series[p].pressure_pa.data(), program_.series() + p * cells,
                       cells * sizeof(Complex32));
      download_channels(tasks[p], p, series[p]);
      series[p].clean_power_pa2.resize(tasks[p].wants_clean ? cells : 0);
      if (!tasks[p].wants_clean) continue;
      queue_->download(series[p].clean_power_pa2.data(), program_.powers() + p * cells,
                       cells * sizeof(float));
    }
  }

  // Of an array alone.
  void download_channels(const PingTask& task, std::size_t p, PingSeries& series) const {
    const bool wanted = setup_.sonar.array && task.wants_channels;
    const std::size_t elements = wanted ? setup_.sonar.array->elements : 0;
    const std::size_t cells = elements * setup_.record.samples;
    series.channels_pa.resize(cells);
    if constexpr (requires { program_.channels(); }) {
      if (cells == 0) return;
      queue_->download(series.channels_pa.data(), program_.channels() + p * cells,
                       cells * sizeof(Complex32));
    }
  }

  std::unique_ptr<Queue> queue_;
  SynthesisSetup setup_;
  mutable std::mutex mutex_;
  mutable Program program_;
  mutable PingBatch batch_;
};

// Beams of sectors, or of an array.
template <class Queue>
std::unique_ptr<Backend> make_device_backend(std::unique_ptr<Queue> queue,
                                             const SynthesisSetup& setup) {
  if (setup.sonar.array) {
    return std::make_unique<DeviceBackend<Queue, ArrayProgram<Queue>>>(std::move(queue), setup);
  }
  return std::make_unique<DeviceBackend<Queue>>(std::move(queue), setup);
}

}  // namespace ensonify
