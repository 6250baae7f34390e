// Pings made and written, sequence by sequence.
//
//   Turns  Turn      who computes
//   Crew             what data sets that are made at the same time share
//   pings_found      those that are not made again
//   make_sequences
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <semaphore>
#include <span>

#include "app/numerics.h"
#include "app/progress.h"
#include "app/sequence_worlds.h"

namespace ensonify {

using Turns = std::counting_semaphore<>;

// As many at once as there are threads.
struct Turn {
  explicit Turn(Turns& all) : turns(all) { turns.acquire(); }
  ~Turn() { turns.release(); }
  Turns& turns;
};

struct Crew {
  const Numerics& numerics;
  int threads = 1;
  Turns& turns;  // one for each thread
  Progress& progress;
  const std::atomic<bool>* stopped = nullptr;  // true ends them as an interrupt does
};

std::uint64_t pings_found(const std::filesystem::path& dir,
                          std::span<const SequenceInfo> sequences);

// Makes the pings of these sequences that are missing from the folder `dir` and finishes each
// sequence. Several sequences are under way at once where one has too few pings to fill the
// threads. `beside`: data sets that are made at the same time, this one counted; a ping takes fewer
// threads then. `ping_done`, unless it is null, is called from any thread. Error kinds: usage (a
// world cannot be built), io, interrupted; what is finished is kept.
Status make_sequences(const Crew& crew, const std::filesystem::path& dir,
                      const SequenceWorlds& worlds, std::span<const SequenceInfo> sequences,
                      int beside = 1, const std::function<void()>& ping_done = {});

}  // namespace ensonify
