// Typed reading of a tree. An absent value leaves `out` as it is; so does a wrong value, which adds
// an error. The returned bool says whether `out` was set.
//
//   Value  child  child_or_empty  item  place_in   a node with its key path
//   open_map  open_list  only_key_of  wrong_kind   the kind that a node must have
//   in_words                                valid numbers
//   read_number  read_numbers  read_integer  read_seed  read_boolean  read_word
//   read_text  is_name
//   refuse_useless                          keys that have no effect in their context
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/keys.h"
#include "scenario/faults.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

struct Value {
  const Node* node = nullptr;
  Place place;
  std::string path;
};

// "map.key", or "key" if the map is the whole text.
std::string joined_path(std::string_view map, std::string_view key);
std::string path_of(const Value& map, std::string_view key);
// The value of a key, or the item of a list at this index.
std::optional<Value> child(const Value& map, std::string_view key);

// The place of the value at a key path, or of the innermost part of the path that the tree has.
// Empty if the tree has no part of it.
std::optional<Place> place_in(const Node& tree, std::string_view path);

// An absent child as an empty map at the place of its parent, so that each missing key is reported.
Value child_or_empty(const Value& map, std::string_view key);

Value item(const Value& list, std::size_t index);

// Returns whether this is a map. Each key that is not in `known` is an error, with the nearest
// known key.
bool open_map(Faults& faults, const Value& value, const std::vector<std::string_view>& known);

bool open_list(Faults& faults, const Value& value);

// Returns the only key of the map that is among `keys`; an error if there is none, or several.
// `what` describes the expected keys.
std::optional<std::string_view> only_key_of(Faults& faults, const Value& map,
                                            const std::vector<std::string_view>& keys,
                                            std::string_view what);

// Adds an error: the value has another kind.
void wrong_kind(Faults& faults, const Value& value, std::string_view accepted);

// "a number > 0, at most 180"
std::string in_words(const NumberRange& range, std::string_view noun);

bool read_number(Faults& faults, const Value& map, std::string_view key, const NumberRange& range,
                 double& out, Need need = Need::optional);

// A list of exactly N numbers.
bool read_numbers(Faults& faults, const Value& map, std::string_view key, const NumberRange& range,
                  double* out, std::size_t count, Need need = Need::optional);

// The same for the value itself.
bool read_numbers_of(Faults& faults, const Value& value, const NumberRange& range, double* out,
                     std::size_t count);

template <std::size_t N>
bool read_numbers(Faults& faults, const Value& map, std::string_view key, const NumberRange& range,
                  std::array<double, N>& out, Need need = Need::optional) {
  return read_numbers(faults, map, key, range, out.data(), N, need);
}

bool read_integer(Faults& faults, const Value& map, std::string_view key, int low, int high,
                  int& out, Need need = Need::optional);

// Any unsigned 64-bit integer, exactly.
bool read_seed(Faults& faults, const Value& map, std::string_view key, std::uint64_t& out);

// Only true or false.
bool read_boolean(Faults& faults, const Value& map, std::string_view key, bool& out);

// Returns the index of one of the words.
std::optional<std::size_t> read_word(Faults& faults, const Value& map, std::string_view key,
                                     const std::vector<std::string_view>& words, Need need);

inline constexpr std::size_t kMaxNameBytes = 128;
inline constexpr std::size_t kMaxFileNameBytes = 4096;

// Printable text of 1 to `max_bytes` bytes. Text that YAML might take for something else must be
// quoted.
bool read_text(Faults& faults, const Value& map, std::string_view key, std::string& out,
               Need need = Need::optional, std::size_t max_bytes = kMaxNameBytes);

// The same for a key that is itself a name.
bool is_name(Faults& faults, const Key& key, const std::string& path);

// Adds an error for each of `keys` that the map has: "has no effect " + `why`.
void refuse_useless(Faults& faults, const Value& map, const std::vector<std::string_view>& keys,
                    std::string_view why);

}  // namespace ensonify
