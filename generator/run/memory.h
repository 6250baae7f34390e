// Memory of the process.
//
//   resident_memory             current and peak memory
//   cpu_memory                  of the backend
//   RunMemory  run_memory       what generating holds
//   peak_bytes                  at most, before and after pings were measured
//   added_bytes                 what generating adds, without a reserve
#pragma once

#include <cstdint>

#include "ping/ping_echoes.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "synthesis/backend.h"

namespace ensonify {

struct ResidentMemory {
  std::uint64_t now_bytes = 0, peak_bytes = 0;
  // Of one process beside this one that read a file.
  std::uint64_t import_bytes = 0;
};

// As counted by the kernel, without memory that could be freed; an estimate for an empty process if
// the system does not report it.
ResidentMemory resident_memory();

// The memory of the backend `cpu`, which plans assume for each machine.
SynthesisMemory cpu_memory(const Session& session, const Numerics& numerics);

// What a `generate` holds of each kind, and how many of each.
struct RunMemory {
  // At the same time. Every sequence keeps the scratch memory of its own pings and threads.
  struct Count {
    std::uint64_t sequences = 1, worlds = 0, computing = 1, waiting = 0, scratches = 1, workers = 1;
  };
  Count count;
  // For each; a world is one in addition to the first. Pings that are measured have no files of
  // their sequence.
  std::uint64_t sequence_bytes = 0, file_bytes = 0, world_bytes = 0, ping_bytes = 0,
                waiting_bytes = 0, scratch_bytes = 0, thread_bytes = 0;
  std::uint64_t loaded_bytes = 0;  // before the first ping
  std::uint64_t loading_peak_bytes = 0;
};

// Of this session. Memory after loading is measured, not estimated: `loaded` is the memory of a
// process that has only prepared the session and traced it, of which `synthesis` is a part. {0, 0}:
// one of several runs in a process, in addition to what it has loaded. `echoes`: as count_echoes or
// most_echoes.
RunMemory run_memory(const Session& session, int threads, const ResidentMemory& loaded,
                     const EchoCounts& echoes, const SynthesisMemory& synthesis);

// The peak memory of that run, with a reserve.
std::uint64_t peak_bytes(const RunMemory& run);

// The same, where `resident` is the memory of a process that has made pings of the session as
// `measured` says.
std::uint64_t peak_bytes(const RunMemory& run, RunMemory::Count measured,
                         const ResidentMemory& resident);

// What the run takes in addition to what is loaded, without a reserve.
std::uint64_t added_bytes(const RunMemory& run);

}  // namespace ensonify
