// One stream of a device with buffers of its own: batches that fit, results back to the host.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <memory_resource>
#include <new>
#include <span>
#include <vector>

#include "core/error.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/picture_kernels.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// Of the free memory, what a batch may take; the rest is for transforms' own and for other lanes.
inline constexpr double kBatchShare = 0.6;
inline constexpr std::size_t kMostPings = 64;

template <class Queue, class Program>
class DeviceLane {
 public:
  DeviceLane(std::unique_ptr<Queue> queue, const SynthesisSetup& setup)
      : queue_(std::move(queue)), setup_(setup), program_(*queue_, setup) {
    table_bytes_ = queue_->held_bytes();
  }

  // Throws std::bad_alloc where not even one ping fits.
  void run(std::span<const PingTask> tasks, std::span<PingSeries* const> series,
           const Workers& workers) {
    std::size_t most = kMostPings;
    for (std::size_t first = 0; first < tasks.size();) {
      const std::size_t count = std::min(fitting(tasks.subspan(first)), most);
      try {
        run_batch(tasks.subspan(first, count), series.subspan(first, count), workers);
      } catch (const std::bad_alloc&) {
        queue_->wait();  // copies still read the batch that did not fit
        if (count == 1) throw;
        most = count / 2;
        continue;
      }
      first += count;
    }
  }

 private:
  // Where a batch's results land, ping by ping.
  struct Landing {
    explicit Landing(std::pmr::memory_resource* memory)
        : pressure(memory), channels(memory), clean(memory), level(memory) {}
    std::pmr::vector<Complex32> pressure, channels;
    std::pmr::vector<float> clean, level;
  };

  std::size_t cells() const { return std::size_t(setup_.sonar.beam_count) * setup_.record.samples; }
  std::size_t channel_cells() const {
    return setup_.sonar.array ? std::size_t(setup_.sonar.array->elements) * setup_.record.samples
                              : 0;
  }

  // At least one. What this lane keeps is free for its next batch.
  std::size_t fitting(std::span<const PingTask> tasks) const {
    const double free = kBatchShare * static_cast<double>(queue_->free_bytes() +
                                                          queue_->held_bytes() - table_bytes_);
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
      program_.run(batch_, workers);
      finish_series(tasks);
    } catch (const std::bad_alloc&) {
      // Buffers that earlier batches needed larger may be all that is in the way.
      queue_->wait();
      program_.drop_buffers();
      level_.drop();
      program_.run(batch_, workers);
      finish_series(tasks);
    }
    download(tasks);
    queue_->wait();
    workers.for_each(tasks.size(), [&](std::size_t p) { hand_over(tasks[p], p, *series[p]); });
  }

  // The converter, and levels in place of series.
  void finish_series(std::span<const PingTask> tasks) {
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

  template <class T>
  void bring(bool wanted, std::pmr::vector<T>& to, const T* from, std::size_t count,
             std::size_t p) {
    if (wanted) queue_->download(to.data() + p * count, from + p * count, count * sizeof(T));
  }

  void download(std::span<const PingTask> tasks) {
    const auto any = [&](auto wants) {
      return std::ranges::any_of(tasks, wants) ? tasks.size() : std::size_t(0);
    };
    const auto wants_series = [](const PingTask& task) { return !task.only_level; };
    landing_.pressure.resize(any(wants_series) * cells());
    landing_.level.resize(any(&PingTask::only_level) * cells());
    landing_.clean.resize(any(&PingTask::wants_clean) * cells());
    landing_.channels.resize(any(&PingTask::wants_channels) * channel_cells());
    for (std::size_t p = 0; p < tasks.size(); ++p) {
      const PingTask& task = tasks[p];
      bring(!task.only_level, landing_.pressure, program_.series(), cells(), p);
      bring(task.only_level, landing_.level, level_.data(), cells(), p);
      bring(task.wants_clean, landing_.clean, program_.powers(), cells(), p);
      if constexpr (requires { program_.channels(); }) {
        bring(task.wants_channels, landing_.channels, program_.channels(), channel_cells(), p);
      }
    }
  }

  // Memory that `to` has is used again.
  template <class From, class To>
  static void copy_values(bool wanted, const std::pmr::vector<From>& from, std::size_t count,
                          std::size_t p, std::vector<To>& to) {
    static_assert(sizeof(From) == sizeof(To));
    to.resize(wanted ? count : 0);
    if (to.empty()) return;
    std::memcpy(static_cast<void*>(to.data()), from.data() + p * count, count * sizeof(To));
  }

  void hand_over(const PingTask& task, std::size_t p, PingSeries& series) const {
    copy_values(!task.only_level, landing_.pressure, cells(), p, series.pressure_pa);
    copy_values(task.only_level, landing_.level, cells(), p, series.level_db);
    copy_values(task.wants_clean, landing_.clean, cells(), p, series.clean_power_pa2);
    copy_values(task.wants_channels, landing_.channels, channel_cells(), p, series.channels_pa);
  }

  std::unique_ptr<Queue> queue_;
  SynthesisSetup setup_;
  Program program_;
  PingBatch batch_{queue_->host_memory()};
  Landing landing_{queue_->host_memory()};
  DeviceBuffer<float, Queue> level_{*queue_};
  std::size_t table_bytes_ = 0;
};

}  // namespace ensonify
