// Merging trees: the keys of a scenario over those of a preset, `--set` over the scenario.
//
//   merge_over        deep; the upper tree wins
//   apply_overrides   `--set KEY.PATH=VALUE`, in order
//   Setting  apply_setting   a parsed value for a key path
#pragma once

#include <string>
#include <vector>

#include "scenario/faults.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

// Maps are joined key by key; any other value is replaced. A key also replaces the keys that it
// excludes (spacing_deg replaces fov_deg), so that a preset can be changed either way. Each
// alternative of a choice is merged separately. The result has the place of the upper tree.
Node merge_over(Node lower, const Node& upper);

struct Setting {
  std::string path;
  Place place;  // of the path
  Node value;
};

// Items of lists are named by index or by their `name`; the index after the last one appends.
// Missing maps are created. A wrong setting is reported and skipped.
void apply_setting(Node& root, const Setting& setting, Faults& faults);

// Applies the settings in order; each becomes a source of `faults`.
void apply_overrides(Node& root, const std::vector<Override>& overrides, Faults& faults);

}  // namespace ensonify
