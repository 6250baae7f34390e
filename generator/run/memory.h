// Memory of the process.
//
//   resident_memory             current and peak memory
//   cpu_memory                  of the backend
//   peak_bytes  world_bytes     memory needed for generating
#pragma once

#include <cstdint>

#include "ping/ping_echoes.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "synthesis/backend.h"

namespace ensonify {

struct ResidentMemory {
  std::uint64_t now_bytes = 0, peak_bytes = 0;
};

// As counted by the kernel, without memory that could be freed; an estimate for an empty process if
// the system does not report it.
ResidentMemory resident_memory();

// The memory of the backend `cpu`, which plans assume for each machine.
SynthesisMemory cpu_memory(const Session& session, const Numerics& numerics);

// The peak memory of a `generate` of this session. Memory after loading is measured, not estimated:
// `loaded` is the memory of a process that has only prepared the session and traced it, of which
// `synthesis` is a part. Its hierarchies are counted once more, about as much as `generate` keeps
// of what it freed while loading, which resident_memory returns to the system. {0, 0}: one of
// several runs in a process, in addition to what it has loaded. `echoes`: as count_echoes or
// most_echoes.
std::uint64_t peak_bytes(const Session& session, int threads, const ResidentMemory& loaded,
                         const EchoCounts& echoes, const SynthesisMemory& synthesis);

// The memory of a world with its hierarchies, independent of how many sequences share it.
std::uint64_t world_bytes(const World& world);

}  // namespace ensonify
