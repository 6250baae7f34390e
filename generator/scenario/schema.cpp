#include "scenario/schema.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/json.h"
#include "scenario/draw.h"
#include "scenario/key_catalogue.h"

namespace ensonify {
namespace {

constexpr std::string_view kSelf = "#/definitions/@self";

// Values that may be sampled, and the names of things, which may not.
constexpr std::string_view kValueDefinitions = R"({
  "two_numbers": {
    "type": "array", "items": {"$ref": "#/definitions/number"}, "minItems": 2, "maxItems": 2
  },
  "name": {"type": "string", "minLength": 1, "maxLength": 128},
  "number": {
    "description": "A number, or the distribution it is sampled from for each sequence.",
    "type": ["number", "object"],
    "properties": {
      "uniform": {
        "title": "Uniform",
        "description": "[a, b]: a number from a to b; for keys that take integers an integer, both ends included.",
        "allOf": [{"$ref": "#/definitions/two_numbers"}]
      },
      "log_uniform": {
        "title": "Log-uniform",
        "description": "[a, b] with 0 < a <= b: a number whose logarithm is uniform.",
        "allOf": [{"$ref": "#/definitions/two_numbers"}]
      },
      "normal": {
        "title": "Normal", "description": "[mean, standard deviation], standard deviation >= 0.",
        "allOf": [{"$ref": "#/definitions/two_numbers"}]
      },
      "choice": {
        "title": "Choice", "description": "A list of values of equal probability.",
        "type": "array", "minItems": 1, "items": {"$ref": "#/definitions/number"}
      }
    },
    "minProperties": 1, "maxProperties": 1, "additionalProperties": false
  },
  "boolean": {
    "description": "true or false, or a choice of them.", "type": ["boolean", "object"],
    "properties": {
      "choice": {"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/boolean"}}
    },
    "required": ["choice"], "additionalProperties": false
  },
  "text": {
    "description": "Text, or a choice of texts.", "type": ["string", "object"],
    "properties": {
      "choice": {"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/text"}}
    },
    "required": ["choice"], "additionalProperties": false
  },
  "sampled_word": {
    "description": "A choice of words.", "type": "object",
    "properties": {"choice": {"type": "array", "minItems": 1}},
    "required": ["choice"], "additionalProperties": false
  }
})";

// One member; of braces alone nlohmann::json may make a list.
Json with(const char* key, Json value) {
  Json schema = Json::object();
  schema[key] = std::move(value);
  return schema;
}

Json list(std::initializer_list<Json> items) {
  Json all = Json::array();
  for (const Json& item : items) all.push_back(item);
  return all;
}

Json reference(std::string_view name) {
  return with("$ref", fmt::format("#/definitions/{}", name));
}

Json all_of(Json part) { return with("allOf", list({std::move(part)})); }

Json required(const std::vector<std::string>& keys) { return with("required", keys); }

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

// A limit as an integer where it is one, which is how it is written.
Json limit(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? Json(whole) : Json(value);
}

void add_range(Json& schema, const NumberRange& range) {
  schema[range.low_excluded ? "exclusiveMinimum" : "minimum"] = limit(range.low);
  schema["maximum"] = limit(range.high);
}

// What a map or a list may be in place of itself; `items` is null for any.
Json choice_of(const Json& items) {
  Json choice = with("type", "array");
  choice["minItems"] = 1;
  if (items.is_null()) return choice;
  choice["description"] = "A list of values of equal probability, one for each sequence.";
  choice["items"] = items;
  return choice;
}

Json list_of(Json items, std::size_t least, std::size_t most) {
  Json schema = with("type", list({"array", "object"}));
  schema["items"] = std::move(items);
  if (least > 0) schema["minItems"] = least;
  if (most < std::numeric_limits<std::size_t>::max()) schema["maxItems"] = most;
  schema["properties"] = with("choice", choice_of(nullptr));
  schema["required"] = list({"choice"});
  schema["additionalProperties"] = false;
  return schema;
}

Json text_of(std::size_t most) {
  Json schema = all_of(reference("text"));
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
      schema = all_of(reference("number"));
      add_range(schema, node.range);
      return schema;
    case ValueType::numbers: {
      Json item = all_of(reference("number"));
      add_range(item, node.range);
      return list_of(std::move(item), node.count, node.count);
    }
    case ValueType::integer:
      if (node.low == node.high) return with("const", node.low);
      if (is_sampled) schema = all_of(reference("number"));
      schema["type"] = is_sampled ? list({"integer", "object"}) : Json("integer");
      schema["minimum"] = node.low;
      schema["maximum"] = node.high;
      return schema;
    case ValueType::seed:
      return {{"type", "integer"},
              {"minimum", 0},
              {"maximum", std::numeric_limits<std::uint64_t>::max()}};
    case ValueType::boolean:
      return all_of(reference("boolean"));
    case ValueType::text:
      return is_sampled ? text_of(kMaxNameBytes) : all_of(reference("name"));
    case ValueType::material:
      return text_of(kMaxNameBytes);
    case ValueType::file:
      return text_of(kMaxFileNameBytes);
    case ValueType::word:
      return with("anyOf", list({with("enum", node.words), reference("sampled_word")}));
  }
  return nullptr;
}

// Where `exclusion` holds; a value that is sampled may come out as any.
Json circumstance_of(const KeyExclusion& exclusion, bool may_be_sampled) {
  Json schema = required({exclusion.by});
  if (exclusion.word.empty()) return schema;
  const auto as_map = [](const char* key) {
    Json map = with("type", "object");
    map["required"] = list({key});
    return map;
  };
  Json words = list({with("const", exclusion.word), as_map(exclusion.word.c_str())});
  if (may_be_sampled) words.push_back(as_map("choice"));
  schema["properties"] = with(exclusion.by.c_str(), with("anyOf", std::move(words)));
  return schema;
}

// One of `keys`, or a circumstance that takes one of them away.
Json any_required(const KeyNode& map, const std::vector<std::string>& keys) {
  Json any = Json::array();
  for (const std::string& key : keys) any.push_back(required({key}));
  for (const KeyExclusion& exclusion : map.exclusions) {
    const bool of_these = std::find(keys.begin(), keys.end(), exclusion.key) != keys.end();
    const bool beside_them = std::find(keys.begin(), keys.end(), exclusion.by) == keys.end();
    if (!of_these || !beside_them) continue;
    Json circumstance = circumstance_of(exclusion, true);
    if (std::find(any.begin(), any.end(), circumstance) == any.end())
      any.push_back(std::move(circumstance));
  }
  return with("anyOf", std::move(any));
}

bool in_one_group(const KeyNode& map, const KeyExclusion& exclusion) {
  return exclusion.word.empty() &&
         std::any_of(map.groups.begin(), map.groups.end(), [&](const KeyGroup& group) {
           const auto has = [&](const std::string& key) {
             return std::find(group.keys.begin(), group.keys.end(), key) != group.keys.end();
           };
           return has(exclusion.key) && has(exclusion.by);
         });
}

// One of the keys; none as well where none is required, or something takes them away.
void add_group(const KeyNode& map, const KeyGroup& group, Json& rules) {
  Json one = Json::array();
  for (const std::string& key : group.keys) one.push_back(required({key}));
  const Json any = any_required(map, group.keys);
  const bool may_be_none = !group.is_required || any["anyOf"].size() > one.size();
  if (group.is_required && may_be_none) rules.push_back(any);
  if (may_be_none) {
    Json none = with("not", with("anyOf", one));
    one.push_back(std::move(none));
  }
  rules.push_back(with("oneOf", std::move(one)));
}

// Keys that cannot be given with others, one rule for each circumstance.
void add_exclusions(const KeyNode& map, Json& rules) {
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
    Json rule = with("if", circumstance_of(exclusion, false));
    rule["then"] = with("properties", std::move(refused));
    rules.push_back(std::move(rule));
  }
}

// What holds for the keys of a map together.
Json rules_of(const KeyNode& map) {
  Json rules = Json::array();
  std::map<std::string, std::vector<std::string>> unless;
  std::vector<std::string> needed;
  for (const KeyNode& node : map.keys) {
    if (node.is_required && node.unless.empty()) needed.push_back(node.key);
    if (node.is_required && !node.unless.empty()) unless[node.unless].push_back(node.key);
    if (node.is_required_alone) rules.push_back(any_required(map, {node.key}));
  }
  if (!needed.empty()) rules.push_back(required(needed));
  for (const auto& [key, keys] : unless) {
    // Farther up, that key is beyond the reach of a schema.
    if (find_key(map, key) != nullptr) {
      rules.push_back(with("anyOf", list({required({key}), required(keys)})));
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

class SchemaMaker {
 public:
  Json scenario() {
    const KeyNode& root = key_tree();
    Json schema = {
        {"$schema", "http://json-schema.org/draft-07/schema#"},
        {"$id", "urn:ensonify:scenario:1"},
        {"ensonify_schema", 1},
        {"title", "ensonify scenario"},
        {"description",
         "A data set: sonar, water, objects, trajectory and output. See docs/scenario.md."},
        {"type", "object"}};
    schema["properties"] = properties(root);
    schema["additionalProperties"] = false;
    schema["allOf"] = rules_of(root);
    schema["definitions"] = Json::parse(kValueDefinitions);
    for (auto& [name, definition] : definitions_) {
      name_self(definition, fmt::format("#/definitions/{}", name));
      schema["definitions"][name] = std::move(definition);
    }
    return schema;
  }

 private:
  static void name_self(Json& json, const std::string& name) {
    if (json.is_string() && json == kSelf) json = name;
    if (!json.is_structured()) return;
    for (Json& inner : json) name_self(inner, name);
  }

  // The definition that holds this, by its key where that is free.
  Json defined(const std::string& key, const std::string& parent, Json definition) {
    for (const auto& [name, known] : definitions_) {
      if (known == definition) return reference(name);
    }
    const auto is_taken = [&](const std::string& name) {
      return std::any_of(definitions_.begin(), definitions_.end(),
                         [&](const auto& known) { return known.first == name; });
    };
    std::string name = key == "*" ? parent + "_item" : key;
    if (key == "mount") name = "pose";  // which is what it has in common with others
    if (is_taken(name)) name = (parent.empty() ? "scenario" : parent) + "_" + name;
    while (is_taken(name)) name += "_";
    definitions_.emplace_back(name, std::move(definition));
    return reference(name);
  }

  Json properties(const KeyNode& map) {
    Json found = Json::object();
    for (const KeyNode& node : map.keys) {
      const bool is_head = &map == &key_tree() && is_head_key(node.key);
      Json use = {{"title", node.title}, {"description", description_of(node)}};
      if (const std::string_view unit = unit_of(node); !unit.empty()) use["unit"] = unit;
      Json value = value_of(node, map.key, !is_head && node.key != "name");
      // What stands next to a reference itself is not looked at.
      use.update(value.contains("$ref") ? all_of(std::move(value)) : std::move(value));
      add_default(map, node, use);
      found[node.key] = std::move(use);
    }
    return found;
  }

  static std::string description_of(const KeyNode& node) {
    std::string text = node.meaning.substr(0, node.meaning.find("; left out: "));
    if (text.starts_with("left out: ") || text.empty()) return node.title + ".";
    if (text.back() != '.') text += '.';
    return text;
  }

  // The default, or in words what holds where the key is not given.
  static void add_default(const KeyNode& map, const KeyNode& node, Json& use) {
    constexpr std::string_view kLeftOut = "left out: ";
    const std::size_t at = node.meaning.find(kLeftOut);
    if (at != std::string::npos) {
      use["left_out"] = node.meaning.substr(at + kLeftOut.size());
      return;
    }
    const auto group = std::find_if(map.groups.begin(), map.groups.end(), [&](const auto& g) {
      return std::find(g.keys.begin(), g.keys.end(), node.key) != g.keys.end();
    });
    if (node.is_required || node.is_required_alone) {
      use["left_out"] = required_words(map, node);
    } else if (!node.default_text.empty() && (group == map.groups.end() || !group->is_required)) {
      use["default"] = default_of(node);
    } else if (group != map.groups.end()) {
      use["left_out"] = alternative_words(*group, node.key);
    } else if (node.is_map || node.is_list || node.is_kind || node.has_names) {
      if (!has_required(node)) use["left_out"] = "keys' defaults";
    }
  }

  static std::string required_words(const KeyNode& map, const KeyNode& node) {
    if (!node.unless.empty()) return fmt::format("required without a {}", node.unless);
    if (node.is_required) return "required";
    std::vector<std::string> words;
    for (const KeyExclusion& exclusion : map.exclusions) {
      if (exclusion.key != node.key) continue;
      words.push_back(exclusion.word.empty()
                          ? fmt::format("`{}`", exclusion.by)
                          : fmt::format("`{}: {}`", exclusion.by, exclusion.word));
    }
    return fmt::format("required, except with {}", fmt::join(words, " or "));
  }

  static std::string alternative_words(const KeyGroup& group, const std::string& key) {
    if (group.keys.size() > 3) return "one of these";
    std::vector<std::string> others;
    for (const std::string& other : group.keys) {
      if (other != key) others.push_back("`" + other + "`");
    }
    return fmt::format("this or {}", fmt::join(others, " or "));
  }

  static Json default_of(const KeyNode& node) {
    const bool is_text = node.type == ValueType::text || node.type == ValueType::material ||
                         node.type == ValueType::word || node.is_kind;
    if (!is_text) return Json::parse(node.default_text);
    const bool quoted = node.default_text.front() == '"';
    return quoted ? Json::parse(node.default_text) : Json(node.default_text);
  }

  static Json no_options() {
    Json schema = with("type", "object");
    schema["properties"] = with("choice", choice_of(nullptr));
    schema["additionalProperties"] = false;
    return schema;
  }

  Json map_of(const KeyNode& map, bool is_kind_map) {
    Json schema = {{"type", "object"}, {"properties", properties(map)}};
    schema["properties"]["choice"] = choice_of(with("$ref", kSelf));
    schema["additionalProperties"] = false;
    if (is_kind_map) {
      schema["minProperties"] = schema["maxProperties"] = 1;
      return schema;
    }
    schema["if"] = required({"choice"});
    schema["then"] = with("maxProperties", 1);
    if (const Json rules = rules_of(map); !rules.empty()) schema["else"] = with("allOf", rules);
    return schema;
  }

  Json kind_of(const KeyNode& node, const std::string& parent) {
    KeyNode described = node;
    std::vector<std::string> alone;
    for (std::size_t i = 0; i < described.keys.size(); ++i) {
      KeyNode& word = described.keys[i];
      if (i < node.kinds.size()) {
        word.title = node.kinds[i].title;
        word.meaning = node.kinds[i].meaning;
      }
      if (word.type == ValueType::none && !has_required(word)) alone.push_back(word.key);
    }
    Json any = Json::array();
    any.push_back(with("enum", alone));
    any.push_back(map_of(described, true));
    return defined(node.key, parent, with("anyOf", std::move(any)));
  }

  Json value_of(const KeyNode& node, const std::string& parent, bool is_sampled) {
    if (node.is_kind) return kind_of(node, parent);
    if (node.is_list) {
      return list_of(value_of(node.keys.at(0), node.key, is_sampled), node.least, node.most);
    }
    if (node.has_names) {
      const Json item = value_of(node.keys.at(0), node.key, is_sampled);
      Json schema = with("type", "object");
      schema["properties"] = with("choice", Json::object());
      schema["additionalProperties"] = item;
      return schema;
    }
    if (node.is_switch) {
      Json any = Json::array();
      any.push_back(with("type", "boolean"));
      any.push_back(with("enum", list({"on", "off"})));
      any.push_back(map_of(node, false));
      return defined(node.key, parent, with("anyOf", std::move(any)));
    }
    if (node.type == ValueType::none && node.keys.empty()) return no_options();
    if (node.type == ValueType::none) return defined(node.key, parent, map_of(node, false));
    if (!node.is_map || node.keys.empty()) return leaf_schema(node, is_sampled);
    Json any = Json::array();
    any.push_back(leaf_schema(node, is_sampled));
    any.push_back(defined(node.key, parent, map_of(node, false)));
    return with("anyOf", std::move(any));
  }

  std::vector<std::pair<std::string, Json>> definitions_;
};

void add_paths(const KeyNode& map, const std::string& prefix, std::vector<std::string>& paths) {
  for (const KeyNode& node : map.keys) {
    const std::string path = prefix + node.key;
    if (node.type != ValueType::none || node.is_kind || node.is_switch) paths.push_back(path);
    if (!node.is_list && !node.has_names) add_paths(node, path + ".", paths);
  }
}

}  // namespace

std::string scenario_schema() { return json_text(SchemaMaker().scenario()); }

std::vector<std::string> key_paths() {
  std::vector<std::string> paths;
  add_paths(key_tree(), "", paths);
  return paths;
}

}  // namespace ensonify
