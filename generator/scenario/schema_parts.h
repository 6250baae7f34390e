// Parts of the schema of scenarios: single values, and what holds for the keys of a map together.
//
//   json_with  json_list  definition_ref  all_of  required_keys   JSON to build them from
//   unit_of  or_variable  choice_of  list_of  leaf_schema   of a value
//   has_required  rules_of                     of a map
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "formats/json.h"
#include "scenario/key_catalogue.h"

namespace ensonify {

// Of braces alone nlohmann::json may make a list.
Json json_with(const char* key, Json value);
Json json_list(std::initializer_list<Json> items);
Json definition_ref(std::string_view definition);
Json all_of(Json part);
Json required_keys(const std::vector<std::string>& keys);

// The unit in the key's text, or else the one that the key's ending implies; empty if there is
// none.
std::string_view unit_of(const KeyNode& node);

// A value of that type, or the use of a variable.
Json or_variable(const char* type);

// The list of alternatives that may replace a map or a list; `items` is null if any values may.
Json choice_of(const Json& items);

Json list_of(Json items, std::size_t least, std::size_t most);

// Null if the key holds no single value.
Json leaf_schema(const KeyNode& node, bool is_sampled);

// Whether a map cannot be empty.
bool has_required(const KeyNode& map);

// The rules for allOf: which keys are required, and which exclude each other.
Json rules_of(const KeyNode& map);

}  // namespace ensonify
