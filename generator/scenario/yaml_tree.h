// A strict layer over yaml-cpp, which by itself keeps the first of two equal keys, reads 010 as 8
// and follows aliases without limit.
//
//   Node  Key         a plain tree that records where each node was and whether it was quoted
//   read_yaml_map     a document whose top level is a map
//   read_yaml_value   any single value, such as that of --set
//   find              the value of a key
//   values_in         the number of nodes in a tree
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/faults.h"

namespace ensonify {

enum class NodeKind { null, scalar, list, map };

struct Key {
  std::string text;
  bool quoted = false;
  Place place;
};

struct Node {
  NodeKind kind = NodeKind::null;
  bool quoted = false;  // a scalar in quotes or a block is text, whatever it looks like
  Place place;
  std::string text;         // of a scalar
  std::vector<Key> keys;    // of a map, one for each item
  std::vector<Node> items;  // of a map or a list
};

inline constexpr std::size_t kMaxYamlDepth = 64;

// Both report errors to `faults` under `source` and return the part that can be read, so that later
// checks can add their errors; empty if there is no tree. Aliases are expanded; a key that is given
// twice keeps its first value. Never throws.
std::optional<Node> read_yaml_map(const std::string& text, int source, Faults& faults);

// `path` names the value in messages; places have no lines; an empty text is a null.
std::optional<Node> read_yaml_value(const std::string& text, int source, const std::string& path,
                                    Faults& faults);

// The value of a key; null if the map has none.
const Node* find(const Node& map, std::string_view key);
Node* find(Node& map, std::string_view key);

// A copy of the map without a key.
Node without(const Node& map, std::string_view key);

std::size_t values_in(const Node& node);

}  // namespace ensonify
