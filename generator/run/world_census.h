// The number of sequences of a scenario that can be made, estimated by building some of their
// worlds.
//
//   kWorldsLookedAt  WorldCensus  take_census
//   census_lines      the output of `check`
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "dataset/manifest.h"
#include "run/sequence_worlds.h"

namespace ensonify {

inline constexpr std::uint32_t kWorldsLookedAt = 200;

struct WorldCensus {
  std::uint32_t sequences = 0;  // of the scenario
  std::uint32_t looked_at = 0;
  std::vector<SequenceFailure> failed;  // that cannot be made, in ascending order
  PlacementTotals placement;            // of the others; without sequences if nothing is placed
};

// Builds the worlds of up to `most` evenly spaced sequences on all threads, with a progress bar. If
// all sequences share one world, builds only that of the first. Errors: those of
// SequenceWorlds::session except usage, which is one of `failed`.
Result<WorldCensus> take_census(const SequenceWorlds& worlds, std::uint32_t most,
                                const Workers& workers);

// Without line ends; empty if there is only one world.
std::vector<std::string> census_lines(const WorldCensus& census);

}  // namespace ensonify
