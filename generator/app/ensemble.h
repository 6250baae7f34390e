// The pings of a sequence as draws of one scene: their moments, whoever computes what first.
//
//   check_draws  that they are
//   Ensemble     blocks of pings come from several threads at once and are added in their order
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "app/sequence_worlds.h"
#include "app/session.h"
#include "core/error.h"
#include "core/moments.h"
#include "dataset/statistics.h"

namespace ensonify {

// Error (usage), where output.statistics asks for an ensemble: scattering.speckle keeps the draws
// from ping to ping, or the sonar or an object is not at rest.
Status check_draws(const Session& session);

class Ensemble {
 public:
  // Goes on from the checkpoint in `dir`, if there is one. A kill costs what came since the last
  // one.
  Ensemble(std::filesystem::path dir, const SequenceInfo& info,
           std::chrono::milliseconds checkpoint_every = std::chrono::seconds(10));

  // Blocks of kMomentBlock pings from the sequence's first on, the last as short as it comes out.
  std::uint32_t block_count() const;
  std::uint32_t blocks_done() const { return first_block_; }  // in the checkpoint
  PingRange block_pings(std::uint32_t block) const;

  // Waits until all blocks before this one are in, or the ensemble is given up: then nothing
  // happens. May be called from several threads at once, for different blocks. Now and then it
  // writes a checkpoint. Error (io): that cannot be written.
  Status add(std::uint32_t block, SeriesBlock series);
  // Nobody waits any more for what will not come.
  void give_up();
  // When nobody adds: a checkpoint of what is in.
  Status save() const;

  const Moments& moments() const { return moments_; }

 private:
  // Beams that are added at a time: while one block is at one stripe, the next follows behind it.
  static constexpr int kStripeBeams = 16;

  bool wait_for(std::uint32_t block, int stripe);
  void pass_on(std::uint32_t block, int stripe);
  bool checkpoint_is_due();

  std::filesystem::path dir_;
  const SequenceInfo& info_;
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
