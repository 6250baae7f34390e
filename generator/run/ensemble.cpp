#include "run/ensemble.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace ensonify {
Ensemble::Ensemble(std::filesystem::path dir, const SequenceInfo& info, const PooledPixels& pool,
                   std::chrono::milliseconds checkpoint_every)
    : dir_(std::move(dir)),
      info_(info),
      pool_(pool),
      checkpoint_every_(checkpoint_every),
      saved_(std::chrono::steady_clock::now()) {
  auto loaded = load_moments(dir_, info);
  moments_ = loaded ? std::move(*loaded) : no_moments(info);
  start_from_moments();
}

void Ensemble::start_from_moments() {
  first_block_ = static_cast<std::uint32_t>((moments_.count + kMomentBlock - 1) / kMomentBlock);
  const int stripes = (moments_.beams + kStripeBeams - 1) / kStripeBeams;
  next_block_.assign(static_cast<std::size_t>(stripes), first_block_);
}

std::uint32_t Ensemble::block_count() const {
  return (info_.last_ping - info_.first_ping + kMomentBlock - 1) / kMomentBlock;
}

PingRange Ensemble::block_pings(std::uint32_t block) const {
  const std::uint32_t first = info_.first_ping + block * kMomentBlock;
  return {first, std::min(first + kMomentBlock, info_.last_ping)};
}

// The beam behind a stripe must keep the state in which this block found it, because its covariance
// needs the means.
bool Ensemble::wait_for(std::uint32_t block, int stripe) {
  const auto s = static_cast<std::size_t>(stripe);
  const auto is_next = [&] {
    return next_block_[s] == block && (s + 1 == next_block_.size() || next_block_[s + 1] == block);
  };
  std::unique_lock lock(mutex_);
  // A block that has begun runs to its end, and all blocks before it have begun.
  changed_.wait(lock, [&] { return is_next() || (given_up_ && stripe == 0); });
  return is_next();
}

void Ensemble::pass_on(std::uint32_t block, int stripe) {
  const std::lock_guard lock(mutex_);
  next_block_[static_cast<std::size_t>(stripe)] = block + 1;
  changed_.notify_all();
}

bool Ensemble::checkpoint_is_due() {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (now - saved_ < checkpoint_every_) return false;
  saved_ = now;
  return true;
}

Status Ensemble::add(std::uint32_t block, SeriesBlock series) {
  const std::uint64_t before = std::uint64_t{block} * kMomentBlock;
  const int stripes = static_cast<int>(next_block_.size());
  std::optional<MomentsFile> checkpoint;
  for (int stripe = 0; stripe < stripes; ++stripe) {
    if (!wait_for(block, stripe)) return {};
    if (stripe == 0 && checkpoint_is_due()) checkpoint.emplace(dir_, info_, before + series.size());
    const int first = stripe * kStripeBeams, last = std::min(first + kStripeBeams, moments_.beams);
    add_block(series, before, first, last, moments_);
    add_pooled(series, pool_, first, last, moments_);
    if (checkpoint) checkpoint->append(moments_, first, last);
    if (stripe + 1 == stripes) moments_.count = before + series.size();
    pass_on(block, stripe);
  }
  return checkpoint ? checkpoint->commit() : Status();
}

Status Ensemble::follow(MomentSums& sums,
                        const std::function<Result<std::uint32_t>(PingRange)>& make) {
  const auto fetch = [&] {
    sums.read(moments_);
    start_from_moments();
  };
  const std::uint32_t blocks = block_count();
  for (std::uint32_t block = first_block_; block < blocks; block += kFollowedBlocks) {
    const std::uint32_t last = std::min(block + kFollowedBlocks, blocks) - 1;
    const PingRange pings{block_pings(block).first, block_pings(last).second};
    const Result<std::uint32_t> added = make(pings);
    if (!added || *added < pings.second - pings.first) {
      fetch();
      return added ? Status() : added.error();
    }
    if (!checkpoint_is_due()) continue;
    fetch();
    if (Status saved = save(); !saved) return saved;
  }
  fetch();
  return {};
}

void Ensemble::give_up() {
  const std::lock_guard lock(mutex_);
  given_up_ = true;
  changed_.notify_all();
}

Status Ensemble::save() const {
  MomentsFile file(dir_, info_, moments_.count);
  file.append(moments_, 0, moments_.beams);
  return file.commit();
}

}  // namespace ensonify
