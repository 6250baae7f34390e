#include "dataset/member_schema.h"

#include <utility>

namespace ensonify {

Json schema_of(const Json& example) {
  if (example.is_array()) {
    const Json item = example.empty() ? Json::object() : schema_of(example[0]);
    return {{"type", "array"},
            {"items", item},
            {"minItems", example.size()},
            {"maxItems", example.size()}};
  }
  if (example.is_object()) {
    Json schema = {{"type", "object"}, {"properties", Json::object()}, {"required", Json::array()}};
    for (const auto& [key, value] : example.items()) {
      schema["properties"][key] = schema_of(value);
      schema["required"].push_back(key);
    }
    schema["additionalProperties"] = false;
    return schema;
  }
  if (example.is_number_unsigned()) return {{"type", "integer"}, {"minimum", 0}};
  if (example.is_number_integer()) return {{"type", "integer"}};
  return {{"type", example.type_name()}};
}

MemberSchema MemberSchema::visited(const Visit& visit, const std::string& key, std::size_t choice) {
  MemberSchema io;
  io.chosen_key_ = key;
  io.choice_ = choice;
  visit(io);
  return io;
}

Json MemberSchema::object_of(const Visit& visit) {
  const MemberSchema first = visited(visit, "", 0);
  for (const auto& [key, names] : first.words_) {
    Json variants = Json::array();
    bool differ = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      Json object = visited(visit, key, i).object_;
      differ = differ || object != first.object_;
      object["properties"][key] = {{"const", names[i]}};
      variants.push_back(std::move(object));
    }
    if (differ) return {{"oneOf", std::move(variants)}};
  }
  return first.object_;
}

void MemberSchema::add(const std::string& key, Presence presence, Json schema) {
  if (presence == Presence::or_null) schema = {{"anyOf", {std::move(schema), {{"type", "null"}}}}};
  object_["properties"][key] = std::move(schema);
  if (presence != Presence::or_absent && !may_lack_) object_["required"].push_back(key);
}

// Only the sign of a number is a rule of files: programs of other versions may accept larger ones.
void MemberSchema::describe(const KeyText& text, const NumberRange& range) {
  Json& schema = object_["properties"][std::string(text.key)];
  if (range.high > 0 && range.low == 0) {
    schema[range.low_excluded ? "exclusiveMinimum" : "minimum"] = 0;
  }
  schema["title"] = text.title;
  schema["description"] = text.meaning;
  if (!text.unit.empty()) schema["unit"] = text.unit;
}

std::size_t MemberSchema::choose(const std::string& key, std::vector<std::string> names) {
  Json schema = Json::object();
  schema["enum"] = names;
  add(key, Presence::always, std::move(schema));
  words_.push_back({key, std::move(names)});
  return key == chosen_key_ ? choice_ : 0;
}

}  // namespace ensonify
