// How many sequences of a scenario can be made, found by building some of their worlds.
//
//   kWorldsLookedAt  WorldCensus  take_census
//   rate_bound        a probability's upper bound
//   census_lines      what `check` says of it
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/sequence_worlds.h"
#include "core/parallel.h"
#include "dataset/manifest.h"

namespace ensonify {

inline constexpr std::uint32_t kWorldsLookedAt = 200;

struct WorldCensus {
  std::uint32_t sequences = 0;  // of the scenario
  std::uint32_t looked_at = 0;
  std::vector<SequenceFailure> failed;  // those that cannot be made, ascending
  PlacementTotals placement;            // of the others; without sequences: nothing is placed
};

// Builds the worlds of up to `most` sequences, evenly spread, on all threads, with a progress bar.
// Where all sequences share one world, that of the first is all. Errors: those of
// SequenceWorlds::session but usage, which is one of `failed`.
Result<WorldCensus> take_census(const SequenceWorlds& worlds, std::uint32_t most,
                                const Workers& workers);

// The largest probability at which `hits` or fewer of `trials` are seen in one case of 20 (Clopper
// and Pearson 1934, one-sided); 1 where all are hits.
double rate_bound(std::uint64_t hits, std::uint64_t trials);

// Without line ends; empty where there is one world.
std::vector<std::string> census_lines(const WorldCensus& census);

}  // namespace ensonify
