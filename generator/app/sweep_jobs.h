// The runs of a sweep that are to be made, and one of them.
//
//   Job  SweepRoom  jobs_of
//   make_run
#pragma once

#include <atomic>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/make_dataset.h"
#include "app/make_sequences.h"
#include "app/sweep_parts.h"
#include "sweep/expand.h"

namespace ensonify {

struct Job {
  const SweepRun* run = nullptr;
  std::string world;                // world_key
  std::string tables;               // table_key
  std::uint64_t pings_of_item = 1;  // what its pings are shared out in
  std::uint64_t items = 0;
};

// Runs of one world come one after another, and among them those of equal tables; otherwise they
// are in their order. Few worlds and tables are then kept at once. Errors: a scenario that cannot
// be made again, since a file of it has gone.
Result<std::vector<Job>> jobs_of(const SweepFile& file, const std::vector<const SweepRun*>& runs,
                                 const Workers& workers);

// What the runs of a process share.
struct SweepRoom {
  const SweepOptions& options;
  const SweepFile& file;
  const Crew& crew;
  RunQueue& queue;
  MemoryGate& gate;
  WorldCache& worlds;
  FileHashes hashes = {};
  std::mutex mutex = {};
  std::set<std::string> warned = {};  // each is told once
};

// Makes the data set of a job, or goes on with it. `taken.run` is its number in the queue. Errors:
// as of `generate`; usage, where an input file is not that of the plan any more. May throw
// std::bad_alloc and DeviceFailure.
Status make_run(SweepRoom& room, const Job& job, const RunQueue::Taken& taken);

}  // namespace ensonify
