// The levels of black and white in a data set's 8-bit images.
//
//   display_limits_db
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "ping/pipeline.h"
#include "run/sequence_worlds.h"

namespace ensonify {

// The limits of the scenario or, if it has none, default_limits_db (labels/display.h) of the first
// pings of the sequences 0, 1, 2, ...: of the first kDisplayProbes that can be made among the first
// kDisplayProbesTried, or of sequence 0 alone if all share one world. They do not depend on the
// number of sequences or on which of them are requested, so that every process gets the same
// limits. `world` returns the world of a sequence; `vary`: each sequence has a world of its own.
// `first`, unless null: known parts of the world of sequence 0, to which new parts are added; with
// `keeps_ping_zero` including the ping. Errors: those of `world` and calibrate except usage, which
// skips a sequence. Throws DeviceFailure.
Result<std::array<double, 2>> display_limits_db(
    const std::function<Result<ReadyWorld>(std::uint32_t sequence)>& world, bool vary,
    const Numerics& numerics, const Workers& workers, SharedParts* first = nullptr,
    bool keeps_ping_zero = false);

inline constexpr int kDisplayProbes = 4;
inline constexpr std::uint32_t kDisplayProbesTried = 16;

}  // namespace ensonify
