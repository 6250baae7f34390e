// Memory of the process.
//
//   resident_memory             current and peak memory
//   count_echoes  most_echoes   of a ping
//   peak_bytes  world_bytes     memory needed for generating
#pragma once

#include <cstdint>

#include "app/ping_echoes.h"
#include "app/session.h"
#include "synthesis/backend.h"

namespace ensonify {

struct ResidentMemory {
  std::uint64_t now_bytes = 0, peak_bytes = 0;
};

// As counted by the kernel, without memory that could be freed; an estimate for an empty process if
// the system does not report it.
ResidentMemory resident_memory();

// The largest count at the first, middle and last ping, which are traced, since no formula predicts
// how many rays hit something.
EchoCounts count_echoes(const Session& session);

// The peak memory of a `generate` of this session. Memory after loading is measured, not estimated:
// `loaded` is the memory of a process that has only prepared the session. `encoded_bytes`: files of
// a ping.
std::uint64_t peak_bytes(const Session& session, int threads, const ResidentMemory& loaded,
                         const EchoCounts& echoes, std::uint64_t encoded_bytes,
                         const SynthesisMemory& synthesis);

// An upper bound for all pings, found without tracing; it is often far too high.
EchoCounts most_echoes(const Session& session);

// The memory of a world with its hierarchies, independent of how many sequences share it.
std::uint64_t world_bytes(const World& world);

}  // namespace ensonify
