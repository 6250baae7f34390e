// Makes pings and writes them, sequence by sequence.
//
//   in_lanes         runs tasks in parallel, in order, until one fails
//   Turns  Turn      limits how many threads compute at the same time
//   Crew             shared by data sets that are made at the same time
//   PingTotals  ping_totals   existing pings, and all
//   SequenceJob  make_sequences
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stage_times.h"
#include "ping/pipeline.h"
#include "ping/tables.h"
#include "run/make_dataset.h"
#include "run/sequence_worlds.h"
#include "run/terminal.h"

namespace ensonify {

// Calls work(lane, i) for i = 0 ... count - 1, in this order, from `lanes` lanes at once, until a
// call fails.
template <class Work>
Status in_lanes(int lanes, std::size_t count, Work work) {
  std::vector<Status> statuses(lanes);
  std::atomic<std::size_t> next = 0;
  Workers(lanes).for_each(lanes, [&](std::size_t lane) {
    for (std::size_t i; (i = next.fetch_add(1)) < count;) {
      statuses[lane] = work(lane, i);
      if (!statuses[lane]) {
        next = count;
        return;
      }
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status;
  }
  return {};
}

// Admits at most `count` threads at once. std::counting_semaphore of libstdc++ 12 is avoided: it
// reads its counter before the attempt that fails, so that it can sleep on a value that is back by
// then (bits/atomic_wait.h).
class Turns {
 public:
  explicit Turns(int count) : free_(count) {}

  void acquire() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return free_ > 0; });
    --free_;
  }

  void release() {
    const std::lock_guard lock(mutex_);
    ++free_;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int free_;
};

struct Turn {
  explicit Turn(Turns& all) : turns(all) { turns.acquire(); }
  ~Turn() { turns.release(); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  Turns& turns;
};

struct Crew {
  const Numerics& numerics;
  int threads = 1;
  Turns& turns;  // one for each thread
  Progress& progress;
  const std::atomic<bool>* stopped = nullptr;  // true ends the work as an interrupt does
  StageTimes* stage_times = nullptr;           // for benchmarks
};

// The pings of the work in the folder `dir`, and all pings: a sequence that the folder does not
// have counts like sequence 0, since it has not been read.
struct PingTotals {
  std::uint64_t found = 0, all = 0;
};
PingTotals ping_totals(const std::filesystem::path& dir, const SequenceWorlds& worlds,
                       const DatasetWork& work);

// The sequences of a data set. `first`: known parts of the world of the first sequence that can be
// made.
struct SequenceJob {
  const Crew& crew;
  const std::filesystem::path& dir;
  const SequenceWorlds& worlds;
  const DatasetWork& work;
  SharedParts first = {};
};

// Makes the pings of the jobs' sequences that are missing in their folders and finishes each
// sequence. Several jobs are the instruments of one rig, with the same sequences and shared turns
// and progress: a sequence is made for all of them before the next one begins. A sequence is read
// when its turn comes. A sequence that cannot be made (its samples are
// not a valid scenario, its world cannot be built, or noise.snr_db has no signal) is recorded
// (dataset/work_folder.h) and leaves nothing else; recorded ones are not tried again. Several
// sequences are in progress at once if one has too few pings for all threads. `beside`: number of
// data sets that are made at the same time, including these; a ping uses fewer threads then.
// `ping_done`, unless null, is called from any thread. Error kinds: io, interrupted, device, bug,
// final_usage (of_sequence); finished work is kept.
Status make_sequences(std::span<SequenceJob> jobs, int beside = 1,
                      const std::function<void()>& ping_done = {});

}  // namespace ensonify
