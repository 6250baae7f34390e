// Memory of the process.
//
//   resident_memory             what it has now and had at most
//   count_echoes  most_echoes   of a ping
//   peak_bytes  world_bytes     what generating will take
#pragma once

#include <cstdint>

#include "app/ping_echoes.h"
#include "app/session.h"
#include "synthesis/backend.h"

namespace ensonify {

struct ResidentMemory {
  std::uint64_t now_bytes = 0, peak_bytes = 0;
};

// As the kernel counts it, without what could be given back; a guess of an empty process where it
// does not say.
ResidentMemory resident_memory();

// The most at the first, the middle and the last ping, which are traced: no formula tells how many
// rays meet something.
EchoCounts count_echoes(const Session& session);

// The peak of a `generate` of this session. What loading took is measured, not estimated: `loaded`
// is of a process that has prepared the session and nothing else. `encoded_bytes`: files of a ping.
std::uint64_t peak_bytes(const Session& session, int threads, const ResidentMemory& loaded,
                         const EchoCounts& echoes, std::uint64_t encoded_bytes,
                         const SynthesisMemory& synthesis);

// No ping has more, found without tracing; often far fewer.
EchoCounts most_echoes(const Session& session);

// What a world takes with its hierarchies, whoever shares it.
std::uint64_t world_bytes(const World& world);

}  // namespace ensonify
