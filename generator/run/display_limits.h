// The levels of black and white in a data set's 8-bit images.
//
//   WorldsFrom  worlds_from_first
//   for_probed_sequences   the sequences that stand for all
//   probe_levels           what ping 0 of one of them says
//   given_limits_db  display_limits_db   the limits of a data set
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "ping/pipeline.h"
#include "run/sequence_worlds.h"

namespace ensonify {

// Returns the world of a sequence.
using WorldOf = std::function<Result<ReadyWorld>(std::uint32_t sequence)>;

// The worlds of a scenario from the first sequence that can be made on.
struct WorldsFrom {
  WorldOf world;
  bool vary = false;  // otherwise all sequences share one
  std::uint32_t first = 0;
};
WorldsFrom worlds_from_first(const SequenceWorlds& worlds);

// Calls `use` with the first kProbes sequences that can be made among kProbesTried from the first
// one on, or with that one alone if all share one world. They do not depend on the number of
// sequences or on which of them are requested, so that every process uses the same. Errors: those
// of `world` and `use` except those of one sequence (usage, final_usage), which is skipped.
Status for_probed_sequences(const WorldsFrom& worlds,
                            const std::function<Status(std::uint32_t, const ReadyWorld&)>& use);

// Two sequences of random_debris give limits within 2 dB of those of four.
inline constexpr int kProbes = 2;
inline constexpr std::uint32_t kProbesTried = 16;

// The echoes of ping 0, none without 8-bit images. Known parts of the world are taken from
// `shared`, and new ones are added, with `keeps_ping_zero` including the ping. Errors: those of
// calibrate. Throws DeviceFailure.
Result<EchoLevels> probe_levels(const ReadyWorld& world, std::uint32_t sequence,
                                const Numerics& numerics, const Workers& workers,
                                SharedParts& shared, bool keeps_ping_zero);

// The limits that the output of a scenario states, any if it has no 8-bit images; else none.
std::optional<std::array<double, 2>> given_limits_db(const OutputSpec& output);

// Those or, if there are none, default_limits_db (labels/display.h) of ping 0 of the probed
// sequences. `first`, unless null: known parts of the first world, as in probe_levels.
// Errors: those of for_probed_sequences and probe_levels.
Result<std::array<double, 2>> display_limits_db(const OutputSpec& output, const WorldsFrom& worlds,
                                                const Numerics& numerics, const Workers& workers,
                                                SharedParts* first = nullptr,
                                                bool keeps_ping_zero = false);

}  // namespace ensonify
