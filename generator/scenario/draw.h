// Values that are drawn: distributions and counts in the tree of a scenario become plain values,
// before the sections are read. A draw is keyed by its key path, in which items of lists stand by
// their name, so that it stays when other objects come, go or change places.
//
//   is_distribution     {uniform: [a, b]}, {log_uniform: ...}, {normal: ...}, {choice: [...]}
//   holds_distribution  anywhere in a tree
//   has_counts          entries of objects or point_targets that stand for several
//   reads_whole_numbers keys whose values are whole numbers
//   draw_values         the tree of one sequence
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "scenario/faults.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

bool is_distribution(const Node& node);
bool holds_distribution(const Node& node);
bool has_counts(std::string_view section, const Node& node);

// Of a key path.
bool reads_whole_numbers(std::string_view path);

// Replaces every distribution below the top level's keys. One that is wrong stays as it is; its
// places are added to `wrong`, so that what is said about it later can be left out.
void draw_values(Node& root, std::uint64_t seed, std::uint32_t sequence, Faults& faults,
                 std::vector<Place>& wrong, std::vector<DrawnValue>& draws);

}  // namespace ensonify
