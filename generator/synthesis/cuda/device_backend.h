// The backend around a device program: batches that fit, results back to the host.
#pragma once

#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <vector>

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
    const bool may_shift = setup_.min_doppler != 0 || setup_.max_doppler != 0;
    memory.echo_bytes =
        sizeof(EchoRecord) + sizeof(std::uint32_t) + (may_shift ? sizeof(ShiftRecord) : 0);
    if (setup_.sonar.array) memory.echo_bytes += array_echo_bytes();
    return memory;
  }

  // There is one device: what several threads ask for while it is at work makes its next batch.
  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    Request mine{tasks, series};
    {
      const std::lock_guard lock(waiting_mutex_);
      waiting_.push_back(&mine);
    }
    {
      const std::lock_guard lock(device_mutex_);
      if (!mine.is_done) run_waiting(workers);
    }
    if (mine.failure) std::rethrow_exception(mine.failure);
  }

 private:
  struct Request {
    std::span<const PingTask> tasks;
    std::span<PingSeries> series;
    bool is_done = false;
    std::exception_ptr failure = {};
  };

  // All that wait by now, as if one caller had asked for them.
  void run_waiting(const Workers& workers) const {
    std::vector<Request*> taken;
    {
      const std::lock_guard lock(waiting_mutex_);
      taken.swap(waiting_);
    }
    std::vector<PingTask> tasks;
    for (const Request* r : taken) tasks.insert(tasks.end(), r->tasks.begin(), r->tasks.end());
    std::vector<PingSeries*> series;
    for (const Request* r : taken) {
      for (PingSeries& s : r->series) series.push_back(&s);
    }
    std::exception_ptr failure;
    try {
      run_batches(tasks, series, workers);
    } catch (...) {
      failure = std::current_exception();
    }
    for (Request* r : taken) {
      r->failure = failure;
      r->is_done = true;
    }
  }

  void run_batches(std::span<const PingTask> tasks, std::span<PingSeries* const> series,
                   const Workers& workers) const {
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

  void run_batch(std::span<const PingTask> tasks, std::span<PingSeries* const> series,
                 const Workers& workers) const {
    fill_batch(setup_, tasks, workers, batch_);
    program_.run(batch_, workers);
    const std::size_t cells = std::size_t(setup_.sonar.beam_count) * setup_.record.samples;
    for (std::size_t p = 0; p < tasks.size(); ++p) {
      PingSeries& result = *series[p];
      result.pressure_pa.resize(cells);
      queue_->download(result.pressure_pa.data(), program_.series() + p * cells,
                       cells * sizeof(Complex32));
      download_channels(tasks[p], p, result);
      result.clean_power_pa2.resize(tasks[p].wants_clean ? cells : 0);
      if (!tasks[p].wants_clean) continue;
      queue_->download(result.clean_power_pa2.data(), program_.powers() + p * cells,
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
  mutable std::mutex device_mutex_, waiting_mutex_;
  mutable std::vector<Request*> waiting_;
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
