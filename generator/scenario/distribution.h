// Which values of a tree are distributions, how many alternatives they have, and whether they are
// valid.
//
//   is_distribution     {uniform: [a, b]}, {log_uniform: ...}, {normal: ...}, {choice: [...]}
//   holds_distribution  anywhere in a tree
//   is_head_key         keys of the top level that key the random numbers and are not sampled
//   is_counted_list     objects and point_targets
//   has_counts          whether a section has entries that stand for several
//   distribution_trouble  whole_number  without_choices
//   draw_variants  variants_of_choice   how many trees have every alternative once
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "scenario/yaml_tree.h"

namespace ensonify {

bool is_distribution(const Node& node);
bool holds_distribution(const Node& node);
bool is_head_key(std::string_view key);
bool is_counted_list(std::string_view path);
bool has_counts(std::string_view section, const Node& node);

// The error in the two numbers of a distribution of this kind; empty if they are valid.
std::string distribution_trouble(std::string_view kind, const std::array<double, 2>& given);

// A number without a fraction that a double can represent.
std::optional<std::int64_t> whole_number(const Node& node);

// The path of the value that a choice replaces, without `.choice.NUMBER`.
std::string without_choices(std::string path);

std::size_t draw_variants(const Node& root);
std::size_t variants_of_choice(const Node& alternatives);  // the list of a choice

}  // namespace ensonify
