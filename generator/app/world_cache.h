// Worlds that several runs share: those whose runs differ in the sonar, the water, the noise, the
// way of the sonar or what is written alone.
//
//   world_key    what a world is made of
//   WorldCache   each built once, and kept until it is forgotten
#pragma once

#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <string>

#include "app/memory_gate.h"
#include "app/sequence_worlds.h"

namespace ensonify {

// Equal keys: build_world gives equal worlds for sequence 0. Empty where every run must have its
// own: something is drawn.
std::string world_key(const Scenario& scenario);

class WorldCache {
 public:
  // Worlds are built in the order in which they are asked for, when `gate` has room for one as
  // large as the largest so far.
  explicit WorldCache(MemoryGate& gate) : gate_(gate) {}

  // Whoever asks first builds it, inside of `turn`; the others wait. An error is kept as well. From
  // several threads at once, none of which holds a turn. `built` is called once for every world.
  Result<BuiltWorld> world(const std::string& key, const Scenario& scenario,
                           const std::function<Result<BuiltWorld>(const Scenario&)>& build);

  // When nobody will ask for it any more; who has it keeps it.
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
