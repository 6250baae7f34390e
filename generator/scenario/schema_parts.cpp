#include "scenario/schema_parts.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace ensonify {

Json json_with(const char* key, Json value) {
  Json schema = Json::object();
  schema[key] = std::move(value);
  return schema;
}

Json json_list(std::initializer_list<Json> items) {
  Json all = Json::array();
  for (const Json& item : items) all.push_back(item);
  return all;
}

Json definition_ref(std::string_view name) {
  return json_with("$ref", fmt::format("#/definitions/{}", name));
}

Json all_of(Json part) { return json_with("allOf", json_list({std::move(part)})); }

Json required_keys(const std::vector<std::string>& keys) { return json_with("required", keys); }

std::string_view unit_of(const KeyNode& node) {
  if (!node.unit.empty()) return node.unit;
  constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
      {"_db_m", "dB/m"}, {"_m_s", "m/s"}, {"_hz", "Hz"}, {"_deg", "°"}, {"_db", "dB"},
      {"_px", "px"},     {"_psu", "psu"}, {"_c", "°C"},  {"_m", "m"},   {"_s", "s"}};
  for (const auto& [ending, unit] : kUnits) {
    if (std::string_view(node.key).ends_with(ending)) return unit;
  }
  return {};
}

// A limit as an integer if it is one, as in the documentation.
static Json limit(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? Json(whole) : Json(value);
}

static void add_range(Json& schema, const NumberRange& range) {
  schema[range.low_excluded ? "exclusiveMinimum" : "minimum"] = limit(range.low);
  schema["maximum"] = limit(range.high);
}

Json or_variable(const char* type) {
  Json schema = json_with("type", json_list({type, "string"}));
  schema["pattern"] = "^\\$[A-Za-z]";
  return schema;
}

Json choice_of(const Json& items) {
  Json choice = json_with("type", "array");
  choice["minItems"] = 1;
  if (items.is_null()) return choice;
  choice["description"] = "A list of values of equal probability, one for each sequence.";
  choice["items"] = items;
  return choice;
}

Json list_of(Json items, std::size_t least, std::size_t most) {
  Json schema = json_with("type", json_list({"array", "object", "string"}));
  schema["pattern"] = "^\\$[A-Za-z]";
  schema["items"] = std::move(items);
  if (least > 0) schema["minItems"] = least;
  if (most < std::numeric_limits<std::size_t>::max()) schema["maxItems"] = most;
  schema["properties"] = json_with("choice", choice_of(nullptr));
  schema["required"] = json_list({"choice"});
  schema["additionalProperties"] = false;
  return schema;
}

static Json text_of(std::size_t most) {
  Json schema = all_of(definition_ref("text"));
  schema["minLength"] = 1;
  schema["maxLength"] = most;
  return schema;
}

Json leaf_schema(const KeyNode& node, bool is_sampled) {
  Json schema;
  switch (node.type) {
    case ValueType::none:
      return nullptr;
    case ValueType::number:
    case ValueType::numbers: {
      schema = all_of(definition_ref("number"));
      add_range(schema, node.range);
      if (node.count == 0) return schema;
      Json list = list_of(schema, node.count, node.count);
      if (node.type == ValueType::numbers) return list;
      return json_with("anyOf", json_list({std::move(schema), std::move(list)}));
    }
    case ValueType::integer:
      if (node.low == node.high) return json_with("const", node.low);
      if (is_sampled) schema = all_of(definition_ref("number"));
      schema["type"] = is_sampled ? json_list({"integer", "object", "string"}) : Json("integer");
      schema["minimum"] = node.low;
      schema["maximum"] = node.high;
      return schema;
    case ValueType::seed:
      return {{"type", "integer"},
              {"minimum", 0},
              {"maximum", std::numeric_limits<std::uint64_t>::max()}};
    case ValueType::boolean:
      return all_of(definition_ref("boolean"));
    case ValueType::text:
      if (is_sampled || node.most_bytes != kMaxNameBytes) return text_of(node.most_bytes);
      return all_of(definition_ref("name"));
    case ValueType::material:
      return text_of(kMaxNameBytes);
    case ValueType::file:
      return text_of(kMaxFileNameBytes);
    case ValueType::word:
      return json_with("anyOf",
                       json_list({json_with("enum", node.words), definition_ref("sampled_word")}));
  }
  return nullptr;
}

// The condition under which `exclusion` applies; a sampled value may turn out to be any word.
static Json circumstance_of(const KeyExclusion& exclusion, bool may_be_sampled) {
  Json schema = required_keys({exclusion.by});
  if (exclusion.word.empty()) return schema;
  const auto as_map = [](const char* key) {
    Json map = json_with("type", "object");
    map["required"] = json_list({key});
    return map;
  };
  Json words = json_list({json_with("const", exclusion.word), as_map(exclusion.word.c_str())});
  if (may_be_sampled) words.push_back(as_map("choice"));
  schema["properties"] = json_with(exclusion.by.c_str(), json_with("anyOf", std::move(words)));
  return schema;
}

// Any of `keys`, or a condition that removes one of them.
static Json any_required(const KeyNode& map, const std::vector<std::string>& keys) {
  Json any = Json::array();
  for (const std::string& key : keys) any.push_back(required_keys({key}));
  for (const KeyExclusion& exclusion : map.exclusions) {
    const bool of_these = std::find(keys.begin(), keys.end(), exclusion.key) != keys.end();
    const bool beside_them = std::find(keys.begin(), keys.end(), exclusion.by) == keys.end();
    if (!of_these || !beside_them) continue;
    Json circumstance = circumstance_of(exclusion, true);
    if (std::find(any.begin(), any.end(), circumstance) == any.end())
      any.push_back(std::move(circumstance));
  }
  return json_with("anyOf", std::move(any));
}

static bool in_one_group(const KeyNode& map, const KeyExclusion& exclusion) {
  return exclusion.word.empty() &&
         std::any_of(map.groups.begin(), map.groups.end(), [&](const KeyGroup& group) {
           const auto has = [&](const std::string& key) {
             return std::find(group.keys.begin(), group.keys.end(), key) != group.keys.end();
           };
           return has(exclusion.key) && has(exclusion.by);
         });
}

// Requires one of the keys, or none if none is required or a condition removes it.
static void add_group(const KeyNode& map, const KeyGroup& group, Json& rules) {
  Json one = Json::array();
  for (const std::string& key : group.keys) one.push_back(required_keys({key}));
  Json any = any_required(map, group.keys);
  // A preset beside them may have one of the keys.
  if (find_key(map, "preset") != nullptr) any["anyOf"].push_back(required_keys({"preset"}));
  const bool may_be_none = !group.is_required || any["anyOf"].size() > one.size();
  if (group.is_required && may_be_none) rules.push_back(any);
  if (may_be_none) {
    Json none = json_with("not", json_with("anyOf", one));
    one.push_back(std::move(none));
  }
  rules.push_back(json_with("oneOf", std::move(one)));
}

// Keys that cannot be given with others, one rule for each condition.
static void add_exclusions(const KeyNode& map, Json& rules) {
  std::vector<KeyExclusion> said;
  for (const KeyExclusion& exclusion : map.exclusions) {
    if (in_one_group(map, exclusion)) continue;
    const auto same = [&](const KeyExclusion& other) {
      return other.by == exclusion.by && other.word == exclusion.word;
    };
    if (std::any_of(said.begin(), said.end(), same)) continue;
    said.push_back(exclusion);
    Json refused = Json::object();
    for (const KeyExclusion& other : map.exclusions) {
      if (same(other) && !in_one_group(map, other)) refused[other.key] = false;
    }
    Json rule = json_with("if", circumstance_of(exclusion, false));
    rule["then"] = json_with("properties", std::move(refused));
    rules.push_back(std::move(rule));
  }
}

Json rules_of(const KeyNode& map) {
  Json rules = Json::array();
  std::map<std::string, std::vector<std::string>> unless;
  std::vector<std::string> needed;
  for (const KeyNode& node : map.keys) {
    if (node.is_required && node.unless.empty()) needed.push_back(node.key);
    if (node.is_required && !node.unless.empty()) unless[node.unless].push_back(node.key);
    if (node.is_required_alone) rules.push_back(any_required(map, {node.key}));
  }
  if (!needed.empty()) rules.push_back(required_keys(needed));
  for (const auto& [key, keys] : unless) {
    // A key farther up is out of reach for a schema.
    if (find_key(map, key) != nullptr) {
      rules.push_back(json_with("anyOf", json_list({required_keys({key}), required_keys(keys)})));
    }
  }
  for (const KeyGroup& group : map.groups) add_group(map, group, rules);
  add_exclusions(map, rules);
  return rules;
}

bool has_required(const KeyNode& map) {
  const auto needed = [](const KeyNode& node) {
    return node.is_required || node.is_required_alone;
  };
  const auto forced = [](const KeyGroup& group) { return group.is_required; };
  return std::any_of(map.keys.begin(), map.keys.end(), needed) ||
         std::any_of(map.groups.begin(), map.groups.end(), forced);
}

}  // namespace ensonify
