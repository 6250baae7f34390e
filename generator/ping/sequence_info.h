// What the files of a sequence say about it.
//
//   sequence_info
//   pick_split      train, val or test
#pragma once

#include <cstdint>
#include <string>

#include "ping/session.h"

namespace ensonify {

// The result lacks limits of 8-bit images that the scenario does not state (display_limits.h), and
// the noise power of an snr_db, which needs the expected image of ping 0.
SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping);

// The choice depends only on seed and sequence, and not on the other sequences of the run.
std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence);

}  // namespace ensonify
