// Which run of a sweep starts when: as soon as those under way leave threads without a ping.
//
//   RunQueue   take, ping_done, finish, stop
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace ensonify {

class RunQueue {
 public:
  // `items`: of each run, what its pings are shared out in (cost.h, work_items). Runs start in this
  // order.
  RunQueue(std::vector<std::uint64_t> items, int threads);

  // Runs that may be under way at once.
  int lanes() const;

  struct Taken {
    std::size_t run = 0;
    int beside = 1;  // runs that will be under way with it, itself counted
  };
  // Waits until the next run should start; nothing when all have been taken, or after stop().
  std::optional<Taken> take();

  void item_done(std::size_t run);
  // Whatever was left of it.
  void finish(std::size_t run);
  void stop();

 private:
  std::uint64_t wanted() const;

  int threads_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint64_t> left_;  // items of each run
  std::size_t next_ = 0, under_way_ = 0;
  std::uint64_t items_under_way_ = 0;
  bool stopped_ = false;
};

}  // namespace ensonify
