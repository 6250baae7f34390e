// What decides which run of a sweep starts when, and what runs side by side share.
//
//   RunQueue           a run starts as soon as those under way leave threads without a ping
//   available_memory   what this process may still take of the machine
//   MemoryGate         memory that runs share: who does not fit waits
//   world_key          what a world is made of
//   WorldCache         each world is built once, and kept until it is forgotten
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/sequence_worlds.h"

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

// What the kernel says is available, or less where control groups (of a batch system, of a
// container) leave less. `root` is where /proc and /sys stand. Without limits where neither tells.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  enum class What { world, run };

  // Held until it is destroyed or assigned to.
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

  // Waits until it fits. A run that fits nowhere goes when no other run is held, a world when
  // nothing is: the budget bounds how many there are at once, not what one may take.
  Hold hold(What what, std::uint64_t bytes);

  // Corrects what is held, without waiting.
  void resize(Hold& hold, std::uint64_t bytes);

  // Whether it would not have to wait, were all of `runs` as large.
  bool fits(std::uint64_t bytes, std::uint64_t runs) const;

 private:
  std::uint64_t budget_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0;
  std::size_t held_ = 0, runs_ = 0;
};

// Equal keys: build_world gives equal worlds for sequence 0. The key is the whole scenario without
// what is known not to matter, so that what is forgotten keeps worlds apart.
std::string world_key(const Scenario& scenario);

class WorldCache {
 public:
  // Worlds are built in the order in which they are asked for, when `gate` has room for one as
  // large as the largest so far.
  explicit WorldCache(MemoryGate& gate) : gate_(gate) {}

  // Whoever asks first builds it by `build`; the others wait. An error is kept as well. May be
  // called from several threads at once, none of which holds a turn.
  Result<BuiltWorld> world(const std::string& key, const Scenario& scenario,
                           const std::function<Result<BuiltWorld>(const Scenario&)>& build);

  // To be called when nobody will ask for it any more; who has it keeps it.
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
