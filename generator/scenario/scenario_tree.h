// Scenarios of a tree that is read already, for who makes many of one text.
//
//   parse_scenario_tree   the second step of parse_scenario, after the overrides
//   place_in              where a key path stands
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "scenario/faults.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

// As parse_scenario (scenario.h); nothing where `faults` holds any, older ones too. `label` names
// the scenario where it has no name.
std::optional<Scenario> parse_scenario_tree(Node tree, const std::string& label,
                                            const std::filesystem::path& folder, Faults& faults,
                                            std::uint32_t sequence = 0);

// Of the path's value, items of lists by index, or of what stands around it in the tree. Nothing
// where the tree has nothing of the path.
std::optional<Place> place_in(const Node& tree, std::string_view path);

}  // namespace ensonify
