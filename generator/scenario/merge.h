// Laying one tree over another: a scenario's keys over a preset's, `--set` over the scenario.
//
//   merge_over        deep, the upper tree wins
//   apply_overrides   `--set KEY.PATH=VALUE`, in order
#pragma once

#include <vector>

#include "scenario/faults.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

// Maps are joined key by key; anything else is replaced. A key also replaces what excludes it
// (spacing_deg takes the place of fov_deg), so that a preset can be changed either way. Each
// alternative of a choice is laid over by itself. The result stands in the upper tree's place.
Node merge_over(Node lower, const Node& upper);

// Items of lists are named by index, the first one behind the end appends; missing maps are made.
// Each override becomes a source of `faults`; a wrong one is reported and left out.
void apply_overrides(Node& root, const std::vector<Override>& overrides, Faults& faults);

}  // namespace ensonify
