// The runs of a sweep that are to be made, and making one of them.
//
//   Job  SweepRoom  jobs_of
//   make_run
#pragma once

#include <atomic>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "run/make_dataset.h"
#include "run/make_sequences.h"
#include "run/options.h"
#include "run/sweep_parts.h"
#include "sweep/expand.h"

namespace ensonify {

struct Job {
  const SweepRun* run = nullptr;
  std::string world;                // world_key
  std::string tables;               // table_key
  std::uint64_t pings_of_item = 1;  // the units in which its pings are distributed
  std::uint64_t items = 0;
};

// Runs of one world follow each other, and within them those of equal tables; otherwise they are in
// the order of the plan. This order keeps the number of worlds and tables in memory small. Errors:
// a scenario that cannot be loaded again, because one of its files is gone.
Result<std::vector<Job>> jobs_of(const SweepFile& file, const std::vector<const SweepRun*>& runs,
                                 const Workers& workers);

// Shared by the runs of a process.
struct SweepRoom {
  const SweepOptions& options;
  const SweepFile& file;
  const Crew& crew;
  RunQueue& queue;
  MemoryGate& gate;
  WorldCache& worlds;
  FileHashes hashes = {};
  std::mutex mutex = {};
  std::set<std::string> warned = {};  // each is printed once
};

// Makes the data set of a job, or resumes it. `taken.run` is its number in the queue. Errors: those
// of `generate` and numerics_that_fit; usage if an input file differs from that of the plan. May
// throw std::bad_alloc and DeviceFailure.
Status make_run(SweepRoom& room, const Job& job, const RunQueue::Taken& taken);

}  // namespace ensonify
