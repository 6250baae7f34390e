// What the fields of all sections state about keys, without a scenario. The schema, the key
// reference, completions and the table of key_facts.h are derived from it.
//
//   KeyNode  key_tree    every key with its text, its value and its map
//   find_key             in a map
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenario/fields.h"

namespace ensonify {

enum class ValueType { none, number, numbers, integer, seed, boolean, text, material, file, word };

// A key that cannot be given if its map has `by`, with the value `word` if there is one.
struct KeyExclusion {
  std::string key, by, word;
};

// Keys of a map of which only one can be given.
struct KeyGroup {
  std::vector<std::string> keys;
  bool is_required = false;
};

struct KeyNode {
  std::string key;  // "*": each item of a list, or each name that the user chooses
  std::string title, meaning, unit;
  bool is_required = false;
  bool is_required_alone = false;  // if no exclusion of its map removes it
  std::string unless;              // required only if this key is not given

  // A single value; a kind has its words in `words` as well.
  ValueType type = ValueType::none;
  NumberRange range;
  int low = 0, high = 0;
  std::size_t most_bytes = 0;  // of a text
  std::size_t count = 0;       // of numbers; for a number, of those that may replace it
  std::vector<std::string> words, endings;
  std::vector<KindText> kinds;
  std::string default_text;  // as YAML; empty if there is none

  // A container of values. A kind has one node in `keys` for each of its words.
  bool is_map = false, is_list = false, has_names = false, is_kind = false, is_switch = false;
  std::size_t least = 0, most = std::numeric_limits<std::size_t>::max();
  std::vector<KeyNode> keys;
  std::vector<KeyGroup> groups;
  std::vector<KeyExclusion> exclusions;

  // Collected by walking: how often the key was asked for, and under which conditions of its map.
  struct Visits {
    int all = 0, useless = 0, needed = 0;
  };
  using Circumstance = std::pair<std::string, std::string>;  // a key, a word or nothing
  Visits visits;
  std::map<Circumstance, Visits> visits_with;
  struct Turns {
    std::size_t visits = 0, alternatives = 0;
    std::set<std::size_t> seen;
  };
  std::map<std::string, Turns, std::less<>> turns;  // of each choice in the map
};

// Walks through all fields at its first call until each choice has had each of its values, which
// takes as long as checking many scenarios. What reads scenarios asks key_facts.h instead.
const KeyNode& key_tree();

// Null if the map has no such key.
const KeyNode* find_key(const KeyNode& map, std::string_view key);

}  // namespace ensonify
