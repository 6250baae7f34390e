#include "app/run_queue.h"

#include <algorithm>
#include <utility>

#include "app/cost.h"

namespace ensonify {

RunQueue::RunQueue(std::vector<std::uint64_t> items, int threads)
    : threads_(threads), left_(std::move(items)) {}

// Beginning and ending a run takes one thread: others have pings of another run meanwhile.
std::uint64_t RunQueue::wanted() const {
  return static_cast<std::uint64_t>(pings_under_way(threads_, UINT32_MAX)) + threads_;
}

int RunQueue::lanes() const {
  return static_cast<int>(std::min<std::uint64_t>(wanted(), left_.size()));
}

std::optional<RunQueue::Taken> RunQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return stopped_ || next_ == left_.size() || under_way_ == 0 || items_under_way_ < wanted();
  });
  if (stopped_ || next_ == left_.size()) return std::nullopt;
  const std::size_t run = next_++;
  const std::uint64_t items = std::max<std::uint64_t>(left_[run], 1);
  ++under_way_;
  items_under_way_ += left_[run];
  const std::uint64_t by_items = (wanted() + items - 1) / items;
  const std::uint64_t to_come = under_way_ + left_.size() - next_;
  return Taken{run, static_cast<int>(std::min(by_items, to_come))};
}

void RunQueue::item_done(std::size_t run) {
  const std::lock_guard lock(mutex_);
  if (left_[run] == 0) return;
  --left_[run];
  --items_under_way_;
  changed_.notify_all();
}

void RunQueue::finish(std::size_t run) {
  const std::lock_guard lock(mutex_);
  items_under_way_ -= std::exchange(left_[run], 0);
  --under_way_;
  changed_.notify_all();
}

void RunQueue::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

}  // namespace ensonify
