// What the fields of all sections state about keys, without a scenario. The schema, the key
// reference, completions and the merging of trees are derived from it.
//
//   KeyNode  key_tree                 every key with its text, its value and its map
//   excluded_by  excluded_by_value    keys that cannot stand with a key, or with its value
//   names_file                        keys of input files
//   reads_whole_numbers  holds_kind  holds_names   of a key path; items by index or by name
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenario/fields.h"
#include "scenario/yaml_tree.h"

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

const KeyNode& key_tree();

const KeyNode* find_key(const KeyNode& map, std::string_view key);

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

}  // namespace ensonify
