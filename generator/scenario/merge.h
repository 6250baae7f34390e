// Laying one tree over another: a scenario's keys over a preset's, `--set` over the scenario.
//
//   merge_over        deep, the upper tree wins
//   apply_overrides   `--set KEY.PATH=VALUE`, in order
//   Setting  apply_setting   a value that is read already, to a key path
#pragma once

#include <string>
#include <vector>

#include "scenario/faults.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

// Maps are joined key by key; anything else is replaced. A key also replaces what excludes it
// (spacing_deg takes the place of fov_deg), so that a preset can be changed either way. Each
// alternative of a choice is laid over by itself. The result stands in the upper tree's place.
Node merge_over(Node lower, const Node& upper);

struct Setting {
  std::string path;
  Place place;  // of the path
  Node value;
};

// Items of lists are named by index, the first one behind the end appends, or by their `name`;
// missing maps are made. A wrong setting is reported and left out.
void apply_setting(Node& root, const Setting& setting, Faults& faults);

// The same, in order; each override becomes a source of `faults`.
void apply_overrides(Node& root, const std::vector<Override>& overrides, Faults& faults);

}  // namespace ensonify
