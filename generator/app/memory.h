// Memory of the process.
//
//   resident_memory  what it has now and had at most
//   peak_bytes       what generating will take
#pragma once

#include <cstdint>

#include "app/session.h"

namespace ensonify {

struct ResidentMemory {
  std::uint64_t now_bytes = 0, peak_bytes = 0;
};

// As the kernel counts it; a guess of an empty process where it does not say.
ResidentMemory resident_memory();

// Of a `generate` of this session. What loading took is measured, not estimated: to be called by
// the process that has prepared the session and nothing else. `encoded_bytes`: files of a ping.
std::uint64_t peak_bytes(const Session& session, int threads, std::uint64_t encoded_bytes);

}  // namespace ensonify
