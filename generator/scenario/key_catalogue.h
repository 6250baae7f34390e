// What the fields of all sections say of keys as such, without a scenario.
//
//   excluded_by  excluded_by_value    keys that cannot stand beside a key, or beside its value
//   names_file                        keys of input files
//   reads_whole_numbers  holds_kind  holds_names   of a key path; items by index or by name
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "scenario/yaml_tree.h"

namespace ensonify {

std::vector<std::string_view> excluded_by(std::string_view key);

// In the same map as the key.
std::vector<std::string_view> excluded_by_value(std::string_view key, const Node& value);

bool names_file(std::string_view key);

bool reads_whole_numbers(std::string_view path);

// Whether at this path a word stands for a map of it: `flat` for {flat: {}}.
bool holds_kind(std::span<const std::string_view> path);

// Whether the keys of the map at this path are names of the user's, of which none excludes another.
bool holds_names(std::span<const std::string_view> path);

}  // namespace ensonify
