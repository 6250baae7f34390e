// The statistics of a comparison as moments of a fit.
//
//   moments_of    of a recording or a simulation
//   moment_names
#pragma once

#include <string>
#include <vector>

#include "compare/block_statistics.h"
#include "fit/search.h"

namespace ensonify {

// All values of the statistics of pings but side lobes, curves value by value, in one order for
// every data set.
// Curves with a free constant are taken less their mean. Needs 2 blocks or more.
MomentSample moments_of(const BlockStatistics& measured);

// In the same order: "range_width", "level_by_range 4 m".
std::vector<std::string> moment_names(const BlockStatistics& measured);

}  // namespace ensonify
