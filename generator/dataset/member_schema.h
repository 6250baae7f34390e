// The JSON Schema of what a list of members writes: the third class for the templates of
// json_members.h. It has titles, meanings and limits where a struct lists its keys (core/keys.h);
// scripts/make_reference.py adds all others. Private to dataset/.
//
//   MemberSchema   adds the schema of each member to that of an object
//   schema_of  schema_like   of a value
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/json_members.h"

namespace ensonify {

// Of values like this one.
Json schema_of(const Json& example);

template <class T>
Json schema_like(const T& value) {
  return schema_of(value_json(value));
}
inline Json schema_like(ClassKind) {
  return {{"enum", {name_of(ClassKind::thing), name_of(ClassKind::stuff)}}};
}
inline Json schema_like(InstrumentKind) {
  return {{"enum", {name_of(InstrumentKind::camera), name_of(InstrumentKind::navigation)}}};
}
template <class T>
Json schema_like(const std::vector<T>&) {
  return {{"type", "array"}, {"items", schema_like(T{})}};
}
template <class T>
Json schema_like(const std::optional<T>&) {
  Json schema = schema_like(T{});
  schema["type"] = Json::array({schema["type"], "null"});
  return schema;
}

inline Json schema_like(const OneOrMore&) {
  return {{"type", {"number", "array", "null"}}, {"items", {{"type", "number"}}}};
}

// An object whose members depend on a word is visited once with each word, and its schema is oneOf
// of these.
class MemberSchema : public MemberLists<MemberSchema> {
 public:
  static constexpr bool kWrites = false, kReads = false;
  using Visit = std::function<void(MemberSchema& io)>;

  // Of the object whose members `visit` lists.
  static Json object_of(const Visit& visit);

  template <class T>
  void value(const std::string& key, Presence presence, bool, T& value) {
    add(key, presence, schema_like(value));
  }
  void pings(std::uint32_t& first, std::uint32_t& last) {
    add("pings", Presence::always, schema_of(Json::array({first, last})));
  }
  template <class Names>
  void word_of(const char* key, const Names& names, std::size_t& index) {
    index = choose(key, {names.begin(), names.end()});
  }
  void said(const char* key, const Json& value) { add(key, Presence::always, schema_of(value)); }
  void together_if(bool, const Visit& use) {
    const bool outer = std::exchange(may_lack_, true);
    use(*this);
    may_lack_ = outer;
  }

  void object(const std::string& key, Presence presence, bool, const Visit& use) {
    add(key, presence, object_of(use));
  }
  template <class Values, class Use>
  void items(const char* key, Presence presence, const Values&, Use use) {
    const Json item = object_of([&](MemberSchema& io) {
      typename Values::value_type any{};
      use(io, any);
    });
    add(key, presence, {{"type", "array"}, {"items", item}});
  }

  // A member that was added.
  void describe(const KeyText& text, const NumberRange& range);

 private:
  struct Word {
    std::string key;
    std::vector<std::string> names;
  };

  static MemberSchema visited(const Visit& visit, const std::string& key, std::size_t choice);
  void add(const std::string& key, Presence presence, Json schema);
  std::size_t choose(const std::string& key, std::vector<std::string> names);

  Json object_ = schema_of(Json::object());
  std::string chosen_key_;  // of the word that is not the first of its names
  std::size_t choice_ = 0;
  std::vector<Word> words_;
  bool may_lack_ = false;  // the members that are listed now
};

}  // namespace ensonify
