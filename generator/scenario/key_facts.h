// What merging, sampling and sweeping ask about keys. The answers come from a table that the build
// derives from the fields of all sections (list_keys.cpp), since deriving it takes longer than
// reading a scenario.
//
//   excluded_by  excluded_by_value    keys that cannot stand with a key, or with its value
//   names_file                        keys of input files
//   reads_whole_numbers  holds_kind  holds_names   of a key path; items by index or by name
//   KeyFacts  key_facts               the table
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "scenario/yaml_tree.h"

namespace ensonify {

// Of keys that exclude each other in every map that has both.
std::vector<std::string_view> excluded_by(std::string_view key);

// These are in the same map as the key.
std::vector<std::string_view> excluded_by_value(std::string_view key, const Node& value);

bool names_file(std::string_view key);

bool reads_whole_numbers(std::string_view path);

// Whether a word at this path stands for a map of it: `flat` for {flat: {}}.
bool holds_kind(std::span<const std::string_view> path);

// Whether the keys of the map at this path are names chosen by the user, which never exclude each
// other.
bool holds_names(std::span<const std::string_view> path);

// All lists are sorted.
struct KeyFacts {
  struct Exclusion {
    std::string_view key, other;
  };
  struct ValueExclusion {
    std::string_view key, word, other;
  };
  struct PathFact {
    std::string_view path;  // keys joined by dots; "*" for items of lists and chosen names
    bool is_list, has_names, is_kind, is_integer;
  };
  std::span<const Exclusion> exclusions;  // both ways
  std::span<const ValueExclusion> value_exclusions;
  std::span<const std::string_view> files;
  std::span<const PathFact> paths;  // for which one of the four holds
};

// Defined in the source that list_keys.cpp writes.
const KeyFacts& key_facts();

}  // namespace ensonify
