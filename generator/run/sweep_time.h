// How long a sweep takes on this machine, from pings of a few of its runs.
//
//   SweepTime  measured_time
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "run/measure.h"
#include "run/options.h"
#include "sweep/expand.h"

namespace ensonify {

struct SweepTime {
  std::size_t measured = 0;  // runs
  RunTime time;              // of all runs, one process
  double disk_bytes = 0;
};

// Of these runs of the sweep, by number. A few are measured as `check` measures a scenario: those
// of a low, a middle and a high cost; their time and bytes over the estimated ones correct the
// estimates of all runs. Left out: a run whose first pings are expected to take more than
// kMostMeasuredSeconds, that does not fit into memory or cannot be made. None if none is left.
// Throws DeviceFailure.
std::optional<SweepTime> measured_time(const Sweep& sweep, const std::vector<std::size_t>& runs,
                                       const SweepOptions& options);

inline constexpr double kMostMeasuredSeconds = 10;

}  // namespace ensonify
