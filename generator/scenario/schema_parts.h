// Parts of the schema of scenarios: single values, and the rules for the keys of a map.
//
//   json_with  json_list  definition_ref  all_of  required_keys   builders of JSON
//   unit_of  or_variable  choice_of  list_of  leaf_schema   for a value
//   has_required  rules_of                     for a map
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "formats/json.h"
#include "scenario/key_catalogue.h"

namespace ensonify {

// nlohmann::json may take a list in braces for an object, or the reverse, so these build either
// one.
Json json_with(const char* key, Json value);
Json json_list(std::initializer_list<Json> items);
Json definition_ref(std::string_view definition);
Json all_of(Json part);
Json required_keys(const std::vector<std::string>& keys);

// The unit in the key's text, or else the unit that the ending of the key implies; empty if there
// is none.
std::string_view unit_of(const KeyNode& node);

// A value of that type, or the use of a variable.
Json or_variable(const char* type);

// The list of alternatives that may replace a map or a list; `items` is null if any value is valid.
Json choice_of(const Json& items);

Json list_of(Json items, std::size_t least, std::size_t most);

// Null if the key does not hold a single value.
Json leaf_schema(const KeyNode& node, bool is_sampled);

// Whether the map cannot be empty.
bool has_required(const KeyNode& map);

// The rules for allOf: which keys are required, and which exclude each other.
Json rules_of(const KeyNode& map);

}  // namespace ensonify
