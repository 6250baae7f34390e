#include "scenario/schema.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/distribution.h"
#include "scenario/schema_parts.h"

namespace ensonify {
namespace {

constexpr std::string_view kSelf = "#/definitions/@self";

// Definitions of values that may be sampled, and of names, which may not.
constexpr std::string_view kValueDefinitions = R"({
  "two_numbers": {
    "type": "array", "items": {"$ref": "#/definitions/number"}, "minItems": 2, "maxItems": 2
  },
  "name": {"type": "string", "minLength": 1, "maxLength": 128},
  "number": {
    "description": "A number, the distribution it is sampled from for each sequence, or a variable.",
    "type": ["number", "object", "string"], "pattern": "^=|^\\$[A-Za-z]",
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
    "description": "true or false, a choice of them, or a variable.",
    "type": ["boolean", "object", "string"], "pattern": "^\\$[A-Za-z]",
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
    "description": "A choice of words, or a variable.",
    "type": ["object", "string"], "pattern": "^\\$[A-Za-z]",
    "properties": {"choice": {"type": "array", "minItems": 1}},
    "required": ["choice"], "additionalProperties": false
  }
})";

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
    schema["definitions"] = parse_shallow(kValueDefinitions);
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

  // The definition that holds this value, named after its key if that name is free.
  Json defined(const std::string& key, const std::string& parent, Json definition) {
    for (const auto& [name, known] : definitions_) {
      if (known == definition) return definition_ref(name);
    }
    const auto is_taken = [&](const std::string& name) {
      return std::any_of(definitions_.begin(), definitions_.end(),
                         [&](const auto& known) { return known.first == name; });
    };
    std::string name = key == "*" ? parent + "_item" : key;
    if (key == "mount") name = "pose";  // shared with the poses of other things
    const std::string map = parent == "*" ? "item" : parent;
    if (is_taken(name)) name = (map.empty() ? "scenario" : map) + "_" + name;
    while (is_taken(name)) name += "_";
    definitions_.emplace_back(name, std::move(definition));
    return definition_ref(name);
  }

  Json properties(const KeyNode& map) {
    Json found = Json::object();
    for (const KeyNode& node : map.keys) {
      const bool is_head = &map == &key_tree() && is_head_key(node.key);
      Json use = {{"title", node.title}, {"description", description_of(node)}};
      if (const std::string_view unit = unit_of(node); !unit.empty()) use["unit"] = unit;
      Json value = value_of(node, map.key, !is_head && node.key != "name");
      // A validator ignores what stands next to a reference itself.
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

  // Adds the default, or a description of what applies if the key is left out.
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
    if (!node.unless.empty()) return fmt::format("required without {}", node.unless);
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
    if (!is_text) return parse_shallow(node.default_text);
    const bool quoted = node.default_text.front() == '"';
    return quoted ? parse_shallow(node.default_text) : Json(node.default_text);
  }

  static Json no_options() {
    Json schema = or_variable("object");
    schema["properties"] = json_with("choice", choice_of(nullptr));
    schema["additionalProperties"] = false;
    return schema;
  }

  Json map_of(const KeyNode& map, bool is_kind_map) {
    Json schema = or_variable("object");
    schema["properties"] = properties(map);
    schema["properties"]["choice"] = choice_of(json_with("$ref", kSelf));
    schema["additionalProperties"] = false;
    if (is_kind_map) {
      schema["minProperties"] = schema["maxProperties"] = 1;
      return schema;
    }
    schema["if"] = required_keys({"choice"});
    schema["then"] = json_with("maxProperties", 1);
    if (const Json rules = rules_of(map); !rules.empty())
      schema["else"] = json_with("allOf", rules);
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
    any.push_back(json_with("enum", alone));
    any.push_back(map_of(described, true));
    return defined(node.key, parent, json_with("anyOf", std::move(any)));
  }

  Json value_of(const KeyNode& node, const std::string& parent, bool is_sampled) {
    if (node.is_kind) return kind_of(node, parent);
    if (node.is_list) {
      Json list = list_of(value_of(node.keys.at(0), node.key, is_sampled), node.least, node.most);
      if (node.type == ValueType::none) return list;
      return json_with("anyOf", json_list({leaf_schema(node, is_sampled), std::move(list)}));
    }
    if (node.has_names && node.keys.empty()) {
      return {{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", true}};
    }
    if (node.has_names) {
      const Json item = value_of(node.keys.at(0), node.key, is_sampled);
      Json schema = or_variable("object");
      schema["properties"] = json_with("choice", Json::object());
      schema["additionalProperties"] = item;
      return schema;
    }
    if (node.is_switch) {
      Json any = Json::array();
      any.push_back(json_with("type", "boolean"));
      any.push_back(json_with("enum", json_list({"on", "off"})));
      any.push_back(map_of(node, false));
      return defined(node.key, parent, json_with("anyOf", std::move(any)));
    }
    if (node.type == ValueType::none && node.keys.empty()) return no_options();
    if (node.type == ValueType::none) return defined(node.key, parent, map_of(node, false));
    if (!node.is_map || node.keys.empty()) return leaf_schema(node, is_sampled);
    Json any = Json::array();
    any.push_back(leaf_schema(node, is_sampled));
    any.push_back(defined(node.key, parent, map_of(node, false)));
    return json_with("anyOf", std::move(any));
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
