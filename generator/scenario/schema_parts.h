// Parts of the schema of scenarios: single values, and what holds for the keys of a map together.
//
//   json_with  json_list  definition_ref  all_of  required_keys   JSON to build them from
//   unit_of  choice_of  list_of  leaf_schema   of a value
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

// As the key's text gives it, or as the end of the key tells; empty: none.
std::string_view unit_of(const KeyNode& node);

// What a map or a list may be in place of itself; `items` is null for any.
Json choice_of(const Json& items);

Json list_of(Json items, std::size_t least, std::size_t most);

// Null where the key holds no single value.
Json leaf_schema(const KeyNode& node, bool is_sampled);

// Whether a map cannot be empty.
bool has_required(const KeyNode& map);

// Rules for allOf: what is required, what excludes what.
Json rules_of(const KeyNode& map);

}  // namespace ensonify
