// Ensembles on a device. Scatterers and moments stay there, and of each realization only its keys
// are sent.
//
//   EnsembleLane    one stream of a device, which makes and adds the realizations of a scene
//   EnsembleLanes   the lanes of a backend; start() gives one to an ensemble
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "synthesis/adc.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/moment_program.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/cuda_backend.h"

namespace ensonify {

// Lanes of a backend, each with one ensemble at a time; others wait.
inline constexpr int kEnsembleLanes = 2;
// A batch of an ensemble has at most this number of realizations. More than a block of them take at
// most kEnsembleHostBytes, and this share of the device's free memory.
inline constexpr std::size_t kEnsembleBatch = 8 * kMomentBlock;
inline constexpr double kEnsembleShare = 0.4;

template <class Queue, class Program>
class EnsembleLane {
 public:
  EnsembleLane(std::unique_ptr<Queue> queue, const SynthesisSetup& setup)
      : queue_(std::move(queue)), setup_(setup), program_(*queue_, setup) {}

  // Throws std::bad_alloc.
  void start(const Moments& moments, const PooledPixels& pool) {
    filled_ = most_ = 0;
    moments_.start(moments, pool);
    if (lasting_bytes_ == 0) lasting_bytes_ = queue_->held_bytes();
  }

  // As MomentSums.
  std::size_t add(std::span<const PingTask> tasks, const Workers& workers) {
    if (most_ == 0) most_ = fitting(tasks[0]);
    std::size_t added = 0;
    while (added < tasks.size()) {
      const std::size_t count = std::min(most_, tasks.size() - added);
      try {
        add_batch(tasks.subspan(added, count), workers);
        added += count;
      } catch (const std::bad_alloc&) {
        queue_->wait();  // copies may still read the batch that did not fit
        filled_ = 0;
        program_.drop_buffers();
        is_short_ = count <= kMomentBlock;
        if (is_short_) break;
        most_ = blocks_in(count / 2);
      }
    }
    return added;
  }

  void read(Moments& moments) { moments_.read(moments); }

  // Whether the memory did not suffice for a block.
  bool is_short() const { return is_short_; }

 private:
  static std::size_t blocks_in(std::size_t count) {
    return std::max<std::size_t>(1, count / kMomentBlock) * kMomentBlock;
  }

  // The number of realizations of a batch: whole blocks, at least one.
  std::size_t fitting(const PingTask& task) const {
    const bool has_volumes = !task.volumes.empty();
    const std::size_t echoes = task.scatterers->size();
    const std::size_t cells = std::size_t(setup_.sonar.beam_count) * setup_.record.samples;
    const std::size_t echo_bytes =
        sizeof(EchoRecord) + sizeof(std::uint32_t) + (setup_.sonar.array ? array_echo_bytes() : 0);
    const std::size_t host_bytes =
        echoes * echo_bytes + (has_volumes ? cells * sizeof(float) : 0) + sizeof(BatchPing);
    // Buffers of earlier ensembles are available.
    const auto free = static_cast<double>(queue_->free_bytes() + queue_->held_bytes() -
                                          std::min(lasting_bytes_, queue_->held_bytes()));
    const double fits =
        kEnsembleShare * free / static_cast<double>(program_.ping_bytes(echoes, has_volumes));
    const auto most = static_cast<std::size_t>(std::min<double>(fits, kEnsembleBatch));
    return blocks_in(std::min<std::size_t>(most, kEnsembleHostBytes / host_bytes));
  }

  void add_batch(std::span<const PingTask> tasks, const Workers& workers) {
    if (tasks.size() == filled_) {
      fill_keys(setup_, tasks, batch_);
      program_.renew(batch_);
    } else {
      filled_ = 0;
      fill_batch(setup_, tasks, workers, batch_);
      program_.upload(batch_, workers);
      filled_ = tasks.size();
    }
    program_.compute(batch_);
    if (tasks[0].converts && setup_.sonar.adc) {
      const std::int64_t cells = std::int64_t{setup_.sonar.beam_count} * setup_.record.samples;
      queue_->run(static_cast<std::int64_t>(tasks.size()) * cells,
                  ConvertSeries{converter_of(*setup_.sonar.adc), program_.series()});
    }
    moments_.add(program_.series(), static_cast<int>(tasks.size()));
    queue_->wait();
  }

  std::unique_ptr<Queue> queue_;
  SynthesisSetup setup_;
  Program program_;
  MomentProgram<Queue> moments_{*queue_};
  PingBatch batch_{queue_->host_memory()};
  std::size_t filled_ = 0;         // realizations whose scatterers are on the device
  std::size_t most_ = 0;           // realizations of a batch; 0: not known yet
  std::size_t lasting_bytes_ = 0;  // of tables and moments
  bool is_short_ = false;
};

template <class Queue, class Program>
class EnsembleLanes {
 public:
  using Lane = EnsembleLane<Queue, Program>;
  using MakeQueue = std::function<std::unique_ptr<Queue>()>;

  EnsembleLanes(MakeQueue make_queue, const SynthesisSetup& setup)
      : make_queue_(std::move(make_queue)), setup_(setup) {}

  // Waits for a lane. Null if the device has no memory for the moments.
  std::unique_ptr<MomentSums> start(const Moments& moments, const PooledPixels& pool) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return at_work_ < kEnsembleLanes; });
    ++at_work_;
    std::unique_ptr<Lane> lane;
    if (!idle_.empty()) {
      lane = std::move(idle_.back());
      idle_.pop_back();
    }
    lock.unlock();
    auto sums = std::make_unique<Sums>(*this, std::move(lane));
    try {
      if (!sums->lane) sums->lane = std::make_unique<Lane>(make_queue_(), setup_);
      sums->lane->start(moments, pool);
    } catch (const std::bad_alloc&) {
      sums->lane.reset();
      return nullptr;
    }
    return sums;
  }

 private:
  // Gives the lane back when the ensemble is finished.
  struct Sums final : MomentSums {
    Sums(EnsembleLanes& lanes, std::unique_ptr<Lane> its_lane)
        : all(lanes), lane(std::move(its_lane)) {}
    ~Sums() override { all.give_back(std::move(lane)); }
    std::size_t add(std::span<const PingTask> tasks, const Workers& workers) override {
      return lane->add(tasks, workers);
    }
    void read(Moments& moments) override { lane->read(moments); }

    EnsembleLanes& all;
    std::unique_ptr<Lane> lane;
  };

  void give_back(std::unique_ptr<Lane> lane) {
    const std::lock_guard lock(mutex_);
    --at_work_;
    if (lane && !lane->is_short()) idle_.push_back(std::move(lane));
    changed_.notify_all();
  }

  MakeQueue make_queue_;
  SynthesisSetup setup_;
  std::mutex mutex_;  // protects all members below
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Lane>> idle_;
  int at_work_ = 0;
};

}  // namespace ensonify
