// The moments of an ensemble in the memory of a device.
//
//   MomentProgram   starts from moments, adds batches of realizations, and brings the moments back
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/error.h"
#include "core/moments.h"
#include "synthesis/cuda/moment_kernels.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

template <class Queue>
class MomentProgram {
 public:
  explicit MomentProgram(Queue& queue) : queue_(queue) {}

  // Provides all memory that add() needs. Throws std::bad_alloc.
  void start(const Moments& moments, const PooledPixels& pool) {
    beams_ = moments.beams;
    samples_ = moments.samples;
    lags_ = moments.lags;
    count_ = moments.count;
    row_values_ = static_cast<std::int64_t>(moments.row_values());
    means_.need(2 * cells());
    counts_.need(std::size_t(beams_) * kHistogramBins * kCountLanes);
    if (lags_ > 0) parts_.need(kMomentBlock * product_count() * kProductParts);
    values_.put(moments.values);
    weight_.put(pool.weight);
    queue_.wait();
  }

  // series: [realizations][beams][samples] on the device. Blocks begin with the first of them, so
  // that what was added before must be whole blocks.
  void add(const Complex32* series, int realizations) {
    ENSONIFY_ASSERT(count_ % kMomentBlock == 0);
    const Realizations all{series, realizations, beams_, samples_};
    double* const pooled = values_.data() + std::int64_t{kMoments} * samples_;
    queue_.run(2 * cells(), KeepMeans{values_.data(), row_values_, samples_, means_.data()});
    queue_.run(cells(), AddMoments{all, static_cast<double>(count_), means_.data(), row_values_,
                                   values_.data()});
    queue_.run(std::int64_t{beams_} * kCountLanes,
               CountPowers{all, weight_.data(), counts_.data()});
    queue_.run(std::int64_t{beams_} * kHistogramBins,
               AddCounts{counts_.data(), row_values_, pooled});
    if (lags_ > 0) add_products(all, pooled + kHistogramBins);
    count_ += static_cast<std::uint64_t>(realizations);
  }

  void read(Moments& moments) {
    queue_.download(moments.values.data(), values_.data(), moments.values.size() * sizeof(double));
    queue_.wait();
    moments.count = count_;
  }

 private:
  std::int64_t cells() const { return std::int64_t{beams_} * samples_; }
  // The sums of products of all beams.
  std::int64_t product_count() const { return std::int64_t{beams_} * 2 * (lags_ + 1) * 3; }

  // The parts of one block after another are in the same memory.
  void add_products(const Realizations& all, double* products) {
    for (int first = 0; first < all.count; first += kMomentBlock) {
      Realizations block = all;
      block.series += first * all.cells();
      block.count = std::min<int>(kMomentBlock, all.count - first);
      queue_.run(block.count * product_count() / 3 * kProductParts,
                 SumProducts{block, weight_.data(), lags_, parts_.data()});
      queue_.run(product_count(),
                 AddProducts{parts_.data(), block.count, beams_, lags_, row_values_, products});
    }
  }

  Queue& queue_;
  int beams_ = 0, samples_ = 0, lags_ = 0;
  std::int64_t row_values_ = 0;
  std::uint64_t count_ = 0;
  // As Moments::values; KeepMeans; PooledPixels::weight; SumProducts.
  DeviceBuffer<double, Queue> values_{queue_}, means_{queue_}, weight_{queue_}, parts_{queue_};
  DeviceBuffer<std::uint32_t, Queue> counts_{queue_};
};

}  // namespace ensonify
