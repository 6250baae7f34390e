// Scheduling of the runs of a sweep, and the data that concurrent runs share.
//
//   RunQueue           starts a run when those in progress leave threads without a ping
//   MemoryGate         memory that runs share: a run that does not fit waits
//   world_key          everything that a world depends on
//   WorldCache         builds each world once and keeps it until it is forgotten
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "run/sequence_worlds.h"

namespace ensonify {

class RunQueue {
 public:
  // `items`: for each run the units in which its pings are distributed (cost.h, work_items). Runs
  // start in this order.
  RunQueue(std::vector<std::uint64_t> items, int threads);

  // The largest number of runs in progress at once.
  int lanes() const;

  struct Taken {
    std::size_t run = 0;
    int beside = 1;  // runs in progress, including this one
  };
  // Waits until the next run should start; empty when all have been taken, or after stop().
  std::optional<Taken> take();

  void item_done(std::size_t run);
  // Removes the rest of its items.
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

class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  enum class What { world, run };

  // Holds memory until it is destroyed or assigned to.
  class Hold {
   public:
    Hold() = default;
    Hold(Hold&& other) noexcept { *this = std::move(other); }
    Hold& operator=(Hold&& other) noexcept;
    ~Hold() { release(); }

   private:
    friend class MemoryGate;
    void release();
    MemoryGate* gate_ = nullptr;
    What what_ = What::run;
    std::uint64_t bytes_ = 0;
  };

  // Waits until the memory is available. A run that never fits starts when no other run holds
  // memory, and such a world when nothing holds memory: the budget limits the number of runs and
  // worlds, not their size.
  Hold hold(What what, std::uint64_t bytes);

  // Corrects the amount held, without waiting.
  void resize(Hold& hold, std::uint64_t bytes);

  // Whether hold would return without waiting if each of `runs` runs were as large.
  bool fits(std::uint64_t bytes, std::uint64_t runs) const;

 private:
  std::uint64_t budget_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0;
  std::size_t held_ = 0, runs_ = 0;
};

// If keys are equal, build_world gives equal worlds for sequence 0. The key is the whole scenario
// without keys that are known not to matter, so that a forgotten key separates worlds instead of
// mixing them.
std::string world_key(const Scenario& scenario);

class WorldCache {
 public:
  // Builds worlds in the order of requests, when `gate` has room for one as large as the largest so
  // far.
  explicit WorldCache(MemoryGate& gate) : gate_(gate) {}

  // The first caller builds the world by `build`; the others wait. An error is kept as well. May be
  // called from several threads at once, none of which holds a turn.
  Result<BuiltWorld> world(const std::string& key, const Scenario& scenario,
                           const std::function<Result<BuiltWorld>(const Scenario&)>& build);

  // Call it when nobody will request the world any more; current holders keep it.
  void forget(const std::string& key);

 private:
  struct Entry {
    std::shared_future<Result<BuiltWorld>> world;
    MemoryGate::Hold hold;
  };

  MemoryGate& gate_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  std::uint64_t largest_bytes_ = 0;
};

}  // namespace ensonify
