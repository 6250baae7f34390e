// How much of what one ping sees other pings see as well.
//
//   kMostCovisiblePings  check_covisibility  covisibility  covisibility_bytes
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "ping/session.h"
#include "trace/tracer.h"

namespace ensonify {

inline constexpr std::uint32_t kMostCovisiblePings = 4000;

// Error (usage): output.covisibility with more pings than that.
Status check_covisibility(const Session& session);

// [pings x pings] of the sequence, row-major. Row a, column b: ping a looks along 32 x 16 directions
// through the middles of equal cells of its fan; of the points that these meet within its ranges,
// weighted by the solid angles of the cells, the part that ping b sees, with the objects where they
// are then (see_points). NaN if ping a meets nothing. Error: that of `go_on`, which is asked between
// pings.
Result<std::vector<float>> covisibility(const Session& session, const Tracer& tracer,
                                        const SequenceInfo& info, const Workers& workers,
                                        const std::function<Status()>& go_on);

// Memory of the matrix and the points; 0 without output.covisibility.
std::uint64_t covisibility_bytes(const OutputSelection& output, std::uint64_t pings);

}  // namespace ensonify
