// Black and white of a data set's 8-bit images.
//
//   display_limits_db
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "app/pipeline.h"
#include "app/sequence_worlds.h"

namespace ensonify {

// Those of the scenario or, where it gives none, default_limits_db (labels/display.h) of the first
// pings of the sequences 0, 1, 2, ...: of kDisplayProbes that can be made, among the first
// kDisplayProbesTried, or of sequence 0 alone where all share one world. Neither the number of
// sequences nor what is asked of them matters, so that every process gets the same. `world`: that
// of a sequence; `vary`: whether each has one of its own. `first`, unless it is null: what is known
// of the world of sequence 0; what is worked out there is added, with `keeps_ping_zero` the ping as
// well. Errors: those of `world` and calibrate but for usage, which passes a sequence over. Throws
// DeviceFailure.
Result<std::array<double, 2>> display_limits_db(
    const std::function<Result<ReadyWorld>(std::uint32_t sequence)>& world, bool vary,
    const Numerics& numerics, const Workers& workers, SharedParts* first = nullptr,
    bool keeps_ping_zero = false);

inline constexpr int kDisplayProbes = 4;
inline constexpr std::uint32_t kDisplayProbesTried = 16;

}  // namespace ensonify
