// The backend around a device program. Several threads may call it, and waiting requests are joined
// to batches.
//
//   FormLevels      pressure [beams][samples] -> level [samples][beams]
//   DeviceLane      one stream of a device with its own buffers: runs batches that fit into memory
//   DeviceBackend   make_device_backend
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/samples.h"
#include "core/units.h"
#include "synthesis/adc.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/array_program.h"
#include "synthesis/cuda/beam_program.h"
#include "synthesis/cuda/device_ensemble.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/cuda/result_pool.h"

namespace ensonify {

struct FormLevels {
  const Complex32* series;
  int beams, samples;
  float* level_db;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t beam = i % beams, sample = i / beams;
    const Complex32 p = series[beam * samples + sample];
    level_db[i] = image_level_db(p.re * p.re + p.im * p.im);
  }
};

// The share of the free memory for a batch. The rest is for the work areas of transforms and for
// other lanes.
inline constexpr double kBatchShare = 0.6;
inline constexpr std::size_t kMostPings = 64;

// Two lanes, so that one copies while the other computes. Copies take longer than the work, and two
// lanes keep the bus busy, so that events within a lane would gain nothing.
inline constexpr int kDeviceLanes = 2;

template <class Queue, class Program>
class DeviceLane {
 public:
  // The memory of results is that of `results`; null: of a pool of its own.
  DeviceLane(std::unique_ptr<Queue> queue, const SynthesisSetup& setup,
             std::shared_ptr<ResultPool> results = nullptr)
      : queue_(std::move(queue)),
        setup_(setup),
        program_(*queue_, setup),
        results_(results ? std::move(results)
                         : std::make_shared<ResultPool>(queue_->host_memory())) {
    table_bytes_ = queue_->held_bytes();
  }

  const std::shared_ptr<ResultPool>& results() const { return results_; }

  // The memory that one ping needs beyond what is free and what this lane has for its batches.
  std::uint64_t missing_bytes(std::uint64_t scatterers, bool has_volumes) const {
    const std::uint64_t needed = program_.ping_bytes(scatterers, has_volumes);
    return needed - std::min<std::uint64_t>(needed, available_bytes());
  }

  // A batch that does not fit is halved, and later ones are not larger. Throws std::bad_alloc if
  // not even one ping fits.
  void run(std::span<const PingTask> tasks, std::span<PingSeries* const> series,
           const Workers& workers) {
    for (std::size_t first = 0; first < tasks.size();) {
      const std::size_t count = std::min(fitting(tasks.subspan(first)), most_pings_);
      try {
        run_batch(tasks.subspan(first, count), series.subspan(first, count), workers);
      } catch (const std::bad_alloc&) {
        queue_->wait();  // copies may still read the batch that did not fit
        if (count == 1) throw;
        most_pings_ = count / 2;
        continue;
      }
      first += count;
    }
  }

 private:
  std::size_t cells() const { return std::size_t(setup_.sonar.beam_count) * setup_.record.samples; }
  std::size_t channel_cells() const {
    return setup_.sonar.array ? std::size_t(setup_.sonar.array->elements) * setup_.record.samples
                              : 0;
  }

  // Buffers that this lane has are available for its next batch.
  std::size_t available_bytes() const {
    return queue_->free_bytes() + queue_->held_bytes() - table_bytes_;
  }

  // The number of tasks that fit into one batch, at least 1.
  std::size_t fitting(std::span<const PingTask> tasks) const {
    const double free = kBatchShare * static_cast<double>(available_bytes());
    double bytes = 0;
    std::size_t count = 0;
    for (const PingTask& task : tasks) {
      bytes +=
          static_cast<double>(program_.ping_bytes(task.scatterers->size(), !task.volumes.empty()) +
                              (task.only_level ? cells() * sizeof(float) : 0));
      if (count > 0 && bytes > free) break;
      ++count;
    }
    return count;
  }

  void run_batch(std::span<const PingTask> tasks, std::span<PingSeries* const> series,
                 const Workers& workers) {
    fill_batch(setup_, tasks, workers, batch_);
    try {
      compute(tasks, workers);
    } catch (const std::bad_alloc&) {
      // Without the large buffers of earlier batches, the memory may suffice.
      queue_->wait();
      program_.drop_buffers();
      level_.drop();
      compute(tasks, workers);
    }
    std::size_t bytes = 0;
    for (std::size_t p = 0; p < tasks.size(); ++p) bytes += provide(tasks[p], *series[p]);
    results_->keep(kDeviceLanes * bytes);
    for (std::size_t p = 0; p < tasks.size(); ++p) download(tasks[p], p, *series[p]);
    queue_->wait();
  }

  // Computes a batch, applies the ADC to series, and makes levels for tasks that need only these.
  void compute(std::span<const PingTask> tasks, const Workers& workers) {
    program_.upload(batch_, workers);
    program_.compute(batch_);
    const bool any_level = std::ranges::any_of(tasks, &PingTask::only_level);
    if (any_level) level_.need(tasks.size() * cells());
    for (std::size_t p = 0; p < tasks.size(); ++p) {
      Complex32* series = program_.series() + p * cells();
      if (tasks[p].converts && setup_.sonar.adc) {
        queue_->run(cells(), ConvertSeries{converter_of(*setup_.sonar.adc), series});
      }
      if (!tasks[p].only_level) continue;
      queue_->run(cells(), FormLevels{series, setup_.sonar.beam_count, setup_.record.samples,
                                      level_.data() + p * cells()});
    }
  }

  // Gives `to` room for as many values in memory of this lane, and returns their bytes. Memory that
  // `to` has from here is used again.
  template <class T>
  std::size_t provide(std::size_t count, SampleArray<T>& to) {
    if (to.get_allocator().source() != results_) to = SampleArray<T>(SampleAllocator<T>(results_));
    to.clear();
    to.resize(count);
    return count * sizeof(T);
  }

  std::size_t provide(const PingTask& task, PingSeries& series) {
    return provide(task.only_level ? 0 : cells(), series.pressure_pa) +
           provide(task.only_level ? cells() : 0, series.level_db) +
           provide(task.wants_clean ? cells() : 0, series.clean_power_pa2) +
           provide(task.wants_channels ? channel_cells() : 0, series.channels_pa);
  }

  // Copies the values of ping p of the batch, as many as `to` has room for.
  template <class From, class To>
  void download(const From* from, std::size_t p, SampleArray<To>& to) {
    static_assert(sizeof(From) == sizeof(To));
    if (!to.empty()) queue_->download(to.data(), from + p * to.size(), to.size() * sizeof(To));
  }

  // A ping's memory is what the device writes into: nothing is copied afterwards.
  void download(const PingTask& task, std::size_t p, PingSeries& series) {
    download(program_.series(), p, series.pressure_pa);
    if (task.only_level) download(level_.data(), p, series.level_db);
    if (task.wants_clean) download(program_.powers(), p, series.clean_power_pa2);
    if constexpr (requires { program_.channels(); }) {
      if (task.wants_channels) download(program_.channels(), p, series.channels_pa);
    }
  }

  std::unique_ptr<Queue> queue_;
  SynthesisSetup setup_;
  Program program_;
  PingBatch batch_{queue_->host_memory()};
  std::shared_ptr<ResultPool> results_;
  DeviceBuffer<float, Queue> level_{*queue_};
  std::size_t table_bytes_ = 0;
  std::size_t most_pings_ = kMostPings;
};

template <class Queue, class Program = BeamProgram<Queue>>
class DeviceBackend final : public Backend {
 public:
  using MakeQueue = std::function<std::unique_ptr<Queue>()>;

  // Makes one lane. Other lanes are made when they are first needed.
  DeviceBackend(MakeQueue make_queue, const SynthesisSetup& setup)
      : make_queue_(std::move(make_queue)), setup_(setup), to_come_(kDeviceLanes - 1) {
    idle_.push_back(std::make_unique<Lane>(make_queue_(), setup_));
    results_ = idle_.back()->results();
  }

  // Host memory only.
  SynthesisMemory memory(bool has_volumes) const override {
    SynthesisMemory memory;
    const std::uint64_t cells = std::uint64_t(setup_.sonar.beam_count) * setup_.record.samples;
    // Memory that waits in the pool for series and expected power, and uploads of volumes.
    memory.ping_bytes =
        cells * (sizeof(Complex32) + sizeof(float) + (has_volumes ? sizeof(float) : 0));
    const bool may_shift = setup_.min_doppler != 0 || setup_.max_doppler != 0;
    memory.echo_bytes =
        sizeof(EchoRecord) + sizeof(std::uint32_t) + (may_shift ? sizeof(DopplerRecord) : 0);
    if (setup_.sonar.array) {
      memory.echo_bytes += array_echo_bytes();
      memory.ping_bytes +=
          std::uint64_t(setup_.sonar.array->elements) * setup_.record.samples * sizeof(Complex32);
    }
    return memory;
  }

  // 0 while all lanes are at work, which shows that pings fit.
  std::uint64_t missing_bytes(std::uint64_t scatterers, bool has_volumes) const override {
    const std::lock_guard lock(mutex_);
    std::uint64_t least = idle_.empty() ? 0 : std::numeric_limits<std::uint64_t>::max();
    for (const auto& lane : idle_) {
      least = std::min(least, lane->missing_bytes(scatterers, has_volumes));
    }
    return least;
  }

  // Requests that arrive while all lanes are busy form the next batch of the first lane that is
  // free. Throws DeviceFailure if the device fails or has no memory for a single ping.
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

  std::unique_ptr<MomentSums> moment_sums(const Moments& moments,
                                          const PooledPixels& pool) const override {
    return ensembles_.start(moments, pool);
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

  // Runs all waiting requests on one lane. If a lane does not get enough memory and there is
  // another lane, it is removed and its requests wait for the other.
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
      if (!lane) lane = std::make_unique<Lane>(make_queue_(), setup_, results_);
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
          DeviceFailure("not enough memory for one ping on the device; expected --backend cpu, "
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
  std::shared_ptr<ResultPool> results_;
  mutable std::mutex mutex_;  // protects all members below
  mutable std::condition_variable changed_;
  mutable std::vector<Request*> waiting_;
  mutable std::vector<std::unique_ptr<Lane>> idle_;
  mutable int to_come_;
  mutable std::size_t at_work_ = 0;
  mutable EnsembleLanes<Queue, Program> ensembles_{make_queue_, setup_};  // has its own mutex
};

// Makes a backend for beams from beam cells, or from an array if the sonar has one.
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
