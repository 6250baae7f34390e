// The backend around a device program: callers from several threads, batches of what waits.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
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
#include "synthesis/cuda/device_lane.h"

namespace ensonify {

// While one lane computes, the other one copies.
inline constexpr int kDeviceLanes = 2;

template <class Queue, class Program = BeamProgram<Queue>>
class DeviceBackend final : public Backend {
 public:
  using MakeQueue = std::function<std::unique_ptr<Queue>()>;

  // At least one lane; others come when they are first needed.
  DeviceBackend(MakeQueue make_queue, const SynthesisSetup& setup)
      : make_queue_(std::move(make_queue)), setup_(setup), to_come_(kDeviceLanes - 1) {
    idle_.push_back(std::make_unique<Lane>(make_queue_(), setup_));
  }

  // On the host.
  SynthesisMemory memory(bool has_volumes) const override {
    SynthesisMemory memory;
    const std::uint64_t cells = std::uint64_t(setup_.sonar.beam_count) * setup_.record.samples;
    // Series and clean power as they come down, and volumes as they go up.
    memory.ping_bytes =
        cells * (sizeof(Complex32) + sizeof(float) + (has_volumes ? sizeof(float) : 0));
    const bool may_shift = setup_.min_doppler != 0 || setup_.max_doppler != 0;
    memory.echo_bytes =
        sizeof(EchoRecord) + sizeof(std::uint32_t) + (may_shift ? sizeof(ShiftRecord) : 0);
    if (setup_.sonar.array) {
      memory.echo_bytes += array_echo_bytes();
      memory.ping_bytes +=
          std::uint64_t(setup_.sonar.array->elements) * setup_.record.samples * sizeof(Complex32);
    }
    return memory;
  }

  // What comes while all lanes are at work makes the next batch of the first that is free. Throws
  // DeviceFailure where the device fails, or has no memory for a single ping.
  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    Request mine{tasks, series};
    std::unique_lock lock(mutex_);
    waiting_.push_back(&mine);
    for (;;) {
      changed_.wait(lock, [&] { return mine.is_done || (!mine.is_taken && may_start()); });
      if (mine.is_done) break;
      serve(lock, workers);
    }
    if (mine.failure) std::rethrow_exception(mine.failure);
  }

 private:
  using Lane = DeviceLane<Queue, Program>;

  struct Request {
    std::span<const PingTask> tasks;
    std::span<PingSeries> series;
    bool is_taken = false, is_done = false;
    std::exception_ptr failure = {};
  };

  bool may_start() const { return !idle_.empty() || to_come_ > 0; }

  // All that wait by now, on one lane. A lane that finds no memory goes while there is another,
  // and leaves its requests to that.
  void serve(std::unique_lock<std::mutex>& lock, const Workers& workers) const {
    std::vector<Request*> taken(waiting_.begin(), waiting_.end());
    waiting_.clear();
    for (Request* r : taken) r->is_taken = true;
    std::unique_ptr<Lane> lane;
    if (!idle_.empty()) {
      lane = std::move(idle_.back());
      idle_.pop_back();
    } else {
      --to_come_;
    }
    ++at_work_;
    lock.unlock();
    bool lacks_memory = false;
    std::exception_ptr failure;
    try {
      if (!lane) lane = std::make_unique<Lane>(make_queue_(), setup_);
      run(*lane, taken, workers);
    } catch (const std::bad_alloc&) {
      lacks_memory = true;
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --at_work_;
    const bool goes = lacks_memory && at_work_ + idle_.size() > 0;
    if (lacks_memory && !goes) {
      failure = std::make_exception_ptr(
          DeviceFailure("not enough memory for one ping on the device; accepted is --backend cpu, "
                        "fewer beams or rays, or a shorter range"));
    }
    if (goes) {
      lane.reset();
      to_come_ = 0;
      waiting_.insert(waiting_.begin(), taken.begin(), taken.end());
    } else if (lane) {
      idle_.push_back(std::move(lane));
    }
    for (Request* r : taken) {
      r->is_taken = !goes;
      r->is_done = !goes;
      r->failure = goes ? nullptr : failure;
    }
    changed_.notify_all();
  }

  static void run(Lane& lane, std::span<Request* const> requests, const Workers& workers) {
    std::vector<PingTask> tasks;
    std::vector<PingSeries*> series;
    for (const Request* r : requests) {
      tasks.insert(tasks.end(), r->tasks.begin(), r->tasks.end());
      for (PingSeries& s : r->series) series.push_back(&s);
    }
    lane.run(tasks, series, workers);
  }

  MakeQueue make_queue_;
  SynthesisSetup setup_;
  mutable std::mutex mutex_;  // of all below
  mutable std::condition_variable changed_;
  mutable std::vector<Request*> waiting_;
  mutable std::vector<std::unique_ptr<Lane>> idle_;
  mutable int to_come_;
  mutable std::size_t at_work_ = 0;
};

// Beams of sectors, or of an array.
template <class Queue>
std::unique_ptr<Backend> make_device_backend(std::function<std::unique_ptr<Queue>()> make_queue,
                                             const SynthesisSetup& setup) {
  if (setup.sonar.array) {
    return std::make_unique<DeviceBackend<Queue, ArrayProgram<Queue>>>(std::move(make_queue),
                                                                       setup);
  }
  return std::make_unique<DeviceBackend<Queue>>(std::move(make_queue), setup);
}

}  // namespace ensonify
