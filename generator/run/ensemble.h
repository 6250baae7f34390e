// The pings of a sequence as realizations of one scene: their moments, independent of the order in
// which threads compute them.
//
//   Ensemble   takes blocks of pings from several threads and adds them in order, or follows a
//              backend that adds them
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "core/error.h"
#include "core/moments.h"
#include "dataset/statistics.h"
#include "ping/session.h"
#include "synthesis/backend.h"

namespace ensonify {

class Ensemble {
 public:
  // Resumes from the checkpoint in `dir`, if there is one. A kill loses the work since the last
  // checkpoint. `pool` must outlive it.
  Ensemble(std::filesystem::path dir, const SequenceInfo& info, const PooledPixels& pool,
           std::chrono::milliseconds checkpoint_every = std::chrono::seconds(10));

  // Blocks of kMomentBlock pings from the first of the sequence; the last block may be shorter.
  std::uint32_t block_count() const;
  // In the checkpoint, and by a backend.
  std::uint32_t blocks_done() const { return first_block_; }
  PingRange block_pings(std::uint32_t block) const;

  // Waits until all blocks before this one are added. Does nothing if the ensemble is given up. May
  // be called from several threads at once, for different blocks. Writes a checkpoint from time to
  // time. Error (io): it cannot be written.
  Status add(std::uint32_t block, SeriesBlock series);
  // Has a backend add the next blocks, with checkpoints from time to time: make(pings) adds these
  // pings to `sums` and returns how many it added. Ends with the first call that does not add all,
  // or with its error. `sums` start from moments(), and no thread adds blocks. Error (io): a
  // checkpoint cannot be written.
  Status follow(MomentSums& sums, const std::function<Result<std::uint32_t>(PingRange)>& make);
  // Releases all waiting threads, because a block will not come.
  void give_up();
  // Writes a checkpoint while no thread adds blocks.
  Status save() const;

  const Moments& moments() const { return moments_; }
  const PooledPixels& pool() const { return pool_; }

 private:
  // Beams that are added at a time: while one block is at a stripe, the next block follows behind
  // it.
  static constexpr int kStripeBeams = 16;
  // Blocks that a backend adds in one call, after which an interrupt is noticed.
  static constexpr std::uint32_t kFollowedBlocks = 8;

  void start_from_moments();
  bool wait_for(std::uint32_t block, int stripe);
  void pass_on(std::uint32_t block, int stripe);
  bool checkpoint_is_due();

  std::filesystem::path dir_;
  const SequenceInfo& info_;
  const PooledPixels& pool_;
  std::chrono::milliseconds checkpoint_every_;
  Moments moments_;
  std::uint32_t first_block_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint32_t> next_block_;  // of each stripe
  bool given_up_ = false;
  std::chrono::steady_clock::time_point saved_;
};

}  // namespace ensonify
