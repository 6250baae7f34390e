// Members of a JSON object. A template lists them once, in order, and takes any of these classes to
// write, read or describe them.
//
//   MemberWriter  MemberReader   and MemberSchema of member_schema.h
//   Presence           what stands where a value is not there
//   MemberLists        what a list of members may say of `io`, which is one of them:
//     io("key", value)            numbers, texts, lists, pairs of pings
//     io.sometimes  io.null_if    ... that are absent, or null, under a condition
//     io.word  io.word_of         an enumeration by name_of; one of a list of words
//     io.said                     what follows from other members; only written
//     io.group  io.group_if       an object; ... or null where there is none
//     io.flag_or_null  io.flag    ... if this is on; else null, or no member; read: whether it is
//                                 there
//     io.optional  io.maybe       ... of an optional; else null, or no member
//     io.list  io.list_if_any     objects, one for each element; no member for no elements
//     io.together_if              members that are all there, or none of them
//     io.number  io.numbers  io.integer  io.boolean  io.choice  io.part
//                                 keys that a struct lists (core/keys.h)
//
// The reader never throws. A member that is absent, null or of the wrong kind leaves its value
// unchanged; fault() names the first of the wrong kind. Private to dataset/.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/keys.h"
#include "core/ping.h"
#include "formats/json.h"

namespace ensonify {

template <class T>
Json value_json(const T& value) {
  return value;
}
// Structs of doubles in the order of the file.
template <class T>
concept NumbersOnly =
    std::same_as<T, Vec3> || std::same_as<T, Quat> || std::same_as<T, PulseTableRow>;
template <NumbersOnly T>
Json value_json(const T& value) {
  return std::bit_cast<std::array<double, sizeof(T) / sizeof(double)>>(value);
}
inline Json value_json(ClassKind kind) { return name_of(kind); }
inline Json value_json(InstrumentKind kind) { return name_of(kind); }
template <class T>
Json value_json(const std::vector<T>& values) {
  Json json = Json::array();
  for (const T& value : values) json.push_back(value_json(value));
  return json;
}
template <class T>
Json value_json(const std::optional<T>& value) {
  return value ? value_json(*value) : Json(nullptr);
}
inline Json value_json(const OneOrMore& numbers) {
  if (numbers.values.empty()) return nullptr;
  return numbers.values.size() == 1 ? Json(numbers.values[0]) : Json(numbers.values);
}

// Whether the JSON has the value's kind; otherwise the value is unchanged.
inline bool take_value(const Json& json, bool& value) {
  if (json.is_boolean()) value = json.get<bool>();
  return json.is_boolean();
}
template <std::integral T>
bool take_value(const Json& json, T& value) {
  if (json.is_number_unsigned()) {
    const auto number = json.get<std::uint64_t>();
    if (std::in_range<T>(number)) value = static_cast<T>(number);
    return std::in_range<T>(number);
  }
  if (!json.is_number_integer() || !std::in_range<T>(json.get<std::int64_t>())) return false;
  value = static_cast<T>(json.get<std::int64_t>());
  return true;
}
inline bool take_value(const Json& json, double& value) {
  if (json.is_number()) value = json.get<double>();
  return json.is_number();
}
inline bool take_value(const Json& json, std::string& value) {
  if (json.is_string()) value = json.get<std::string>();
  return json.is_string();
}
template <std::size_t N>
bool take_value(const Json& json, std::array<double, N>& values) {
  std::array<double, N> found{};
  bool taken = json.is_array() && json.size() == N;
  for (std::size_t i = 0; taken && i < N; ++i) taken = take_value(json[i], found[i]);
  if (taken) values = found;
  return taken;
}
template <NumbersOnly T>
bool take_value(const Json& json, T& value) {
  std::array<double, sizeof(T) / sizeof(double)> found{};
  const bool taken = take_value(json, found);
  if (taken) value = std::bit_cast<T>(found);
  return taken;
}
inline bool take_value(const Json& json, ClassKind& kind) {
  for (const ClassKind word : {ClassKind::thing, ClassKind::stuff}) {
    if (json != name_of(word)) continue;
    kind = word;
    return true;
  }
  return false;
}
inline bool take_value(const Json& json, InstrumentKind& kind) {
  for (const InstrumentKind word : {InstrumentKind::camera, InstrumentKind::navigation}) {
    if (json != name_of(word)) continue;
    kind = word;
    return true;
  }
  return false;
}
template <class T>
bool take_value(const Json& json, std::optional<T>& value) {
  T found{};
  const bool taken = take_value(json, found);
  if (taken) value = std::move(found);
  return taken;
}
template <class T>
bool take_value(const Json& json, std::vector<T>& values) {
  std::vector<T> found(json.is_array() ? json.size() : 0);
  bool taken = json.is_array();
  for (std::size_t i = 0; taken && i < found.size(); ++i) taken = take_value(json[i], found[i]);
  if (taken) values = std::move(found);
  return taken;
}

inline bool take_value(const Json& json, OneOrMore& numbers) {
  if (double one = 0; take_value(json, one)) {
    numbers.values = {one};
    return true;
  }
  return take_value(json, numbers.values);
}

enum class Presence { always, or_null, or_absent };

// Io has `value`, `object`, `items` and `word_of`, for members that stand as their Presence says.
template <class Io>
class MemberLists {
 public:
  template <class T>
  void operator()(const char* key, T&& value) {
    io().value(key, Presence::always, true, value);
  }
  template <class T>
  void sometimes(bool is_there, const char* key, T&& value) {
    io().value(key, Presence::or_absent, is_there, value);
  }
  template <class T>
  void null_if(bool is_null, const char* key, T& value) {
    io().value(key, Presence::or_null, !is_null, value);
  }

  template <class T, class Word = std::remove_const_t<T>>
  void word(const char* key, T& value, Word last, Word first = Word{}) {
    std::vector<std::string> names;
    for (int i = static_cast<int>(first); i <= static_cast<int>(last); ++i) {
      names.emplace_back(name_of(static_cast<Word>(i)));
    }
    auto index = static_cast<std::size_t>(value) - static_cast<std::size_t>(first);
    io().word_of(key, names, index);
    if constexpr (!Io::kWrites) value = static_cast<Word>(static_cast<std::size_t>(first) + index);
  }

  template <class Use>
  void group(const char* key, Use use) {
    io().object(key, Presence::always, true, use);
  }
  template <class Use>
  void group_if(const char* key, bool is_there, Use use) {
    io().object(key, Presence::or_null, is_there, use);
  }
  template <class Flag, class Use>
  void flag(const char* key, Flag& on, Use use) {
    flagged(key, Presence::or_absent, on, use);
  }
  template <class Flag, class Use>
  void flag_or_null(const char* key, Flag& on, Use use) {
    flagged(key, Presence::or_null, on, use);
  }
  template <class Optional, class Use>
  void optional(const char* key, Optional& value, Use use) {
    held(key, Presence::or_null, value, use);
  }
  template <class Optional, class Use>
  void maybe(const char* key, Optional& value, Use use) {
    held(key, Presence::or_absent, value, use);
  }
  template <class Values, class Use>
  void list(const char* key, Values& values, Use use) {
    io().items(key, Presence::always, values, use);
  }
  template <class Values, class Use>
  void list_if_any(const char* key, Values& values, Use use) {
    io().items(key, Presence::or_absent, values, use);
  }
  template <class Use>
  void together_if(bool are_there, Use use) {
    if (!Io::kWrites || are_there) use(io());
  }

  // Scenarios and sequence.json share these keys. Of a scenario's rules, written_if holds here too:
  // a key that its default does not write may be absent, so that older files stay valid.
  template <class T>
  void number(const KeyText& text, T& value, const NumberRange& range, Rule rule = {}) {
    const std::string key(text.key);
    rule.written ? (*this)(key.c_str(), value) : sometimes(false, key.c_str(), value);
    io().describe(text, range);
  }
  template <class T>
  void numbers(const KeyText& text, T& values, const NumberRange&, Rule rule = {}) {
    number(text, values, {}, rule);
  }
  template <class T>
  void integer(const KeyText& text, T& value, int low, int high, Rule rule = {}) {
    number(text, value, from_to(low, high), rule);
  }
  template <class T>
  void boolean(const KeyText& text, T& value) {
    number(text, value, {});
  }
  template <class Word, class T>
  void choice(const KeyText& text, T& value,
              std::initializer_list<std::pair<std::string_view, Word>> choices) {
    std::vector<std::string> names;
    std::size_t index = 0;
    for (const auto& [name, word] : choices) {
      if (word == value) index = names.size();
      names.emplace_back(name);
    }
    io().word_of(std::string(text.key).c_str(), names, index);
    if constexpr (!Io::kWrites) value = choices.begin()[index].second;
    io().describe(text, {});
  }
  template <class Optional, class Each>
  void part(const KeyText& text, Optional& value, Each each, Rule rule = {}) {
    const std::string key(text.key);
    rule.written ? optional(key.c_str(), value, each) : maybe(key.c_str(), value, each);
    io().describe(text, {});
  }
  void describe(const KeyText&, const NumberRange&) {}  // for a schema

 private:
  Io& io() { return static_cast<Io&>(*this); }

  template <class Flag, class Use>
  void flagged(const char* key, Presence presence, Flag& on, Use use) {
    io().object(key, presence, on, [&](Io& inner) {
      if constexpr (Io::kReads) on = true;
      use(inner);
    });
  }
  template <class Optional, class Use>
  void held(const char* key, Presence presence, Optional& value, Use use) {
    io().object(key, presence, value.has_value(), [&](Io& inner) {
      if constexpr (Io::kWrites) {
        use(inner, *value);
      } else if constexpr (Io::kReads) {
        use(inner, value.emplace());
      } else {
        typename Optional::value_type any{};
        use(inner, any);
      }
    });
  }
};

class MemberWriter : public MemberLists<MemberWriter> {
 public:
  static constexpr bool kWrites = true, kReads = false;
  explicit MemberWriter(Json& json) : json_(json) {}

  template <class T>
  void value(const char* key, Presence presence, bool is_there, const T& value) {
    if (is_there) json_[key] = value_json(value);
    if (!is_there && presence == Presence::or_null) json_[key] = nullptr;
  }
  // [first, last).
  void pings(const std::uint32_t& first, const std::uint32_t& last) {
    json_["pings"] = Json::array({first, last});
  }
  template <class Names>
  void word_of(const char* key, const Names& names, const std::size_t& index) {
    json_[key] = names[index];
  }
  void said(const char* key, Json value) { json_[key] = std::move(value); }

  template <class Use>
  void object(const char* key, Presence presence, bool is_there, Use use) {
    if (is_there) json_[key] = object_of(use);
    if (!is_there && presence == Presence::or_null) json_[key] = nullptr;
  }
  template <class Values, class Use>
  void items(const char* key, Presence presence, const Values& values, Use use) {
    if (values.empty() && presence == Presence::or_absent) return;
    Json items = Json::array();
    for (const auto& value : values) {
      items.push_back(object_of([&](MemberWriter& io) { use(io, value); }));
    }
    json_[key] = std::move(items);
  }

 private:
  template <class Use>
  static Json object_of(Use use) {
    Json json = Json::object();
    MemberWriter io(json);
    use(io);
    return json;
  }

  Json& json_;
};

class MemberReader : public MemberLists<MemberReader> {
 public:
  static constexpr bool kWrites = false, kReads = true;
  // Both must outlive it. `fault` gets the path of the first member of a wrong kind.
  MemberReader(const Json& json, std::string& fault, std::string place = "")
      : json_(json), fault_(fault), place_(std::move(place)) {}

  const Json& json() const { return json_; }

  template <class T>
  void value(const char* key, Presence, bool, T& value) {
    const Json* found = there(key);
    if (found != nullptr && !take_value(*found, value)) refuse(key);
  }
  void pings(std::uint32_t& first, std::uint32_t& last) {
    std::vector<std::uint32_t> range;
    (*this)("pings", range);
    if (range.size() != 2 || range[0] > range[1]) return refuse("pings");
    first = range[0];
    last = range[1];
  }
  template <class Names>
  void word_of(const char* key, const Names& names, std::size_t& index) {
    std::string name;
    (*this)(key, name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (name == names[i]) index = i;
    }
  }
  template <class T>
  void said(const char*, const T&) {}

  template <class Use>
  void object(const char* key, Presence, bool, Use use) {
    const Json* found = there(key);
    if (found == nullptr) return;
    if (!found->is_object()) return refuse(key);
    MemberReader io(*found, fault_, place_ + key + ".");
    use(io);
  }
  template <class T, class Use>
  void items(const char* key, Presence, std::vector<T>& values, Use use) {
    const Json* found = there(key);
    if (found == nullptr) return;
    if (!found->is_array()) return refuse(key);
    values.assign(found->size(), T{});
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!(*found)[i].is_object()) return refuse(key);
      MemberReader io((*found)[i], fault_, place_ + key + "[" + std::to_string(i) + "].");
      use(io, values[i]);
    }
  }

 private:
  const Json* there(const char* key) const {
    const Json* found = member(json_, key);
    return found == nullptr || found->is_null() ? nullptr : found;
  }
  void refuse(const std::string& key) {
    if (fault_.empty()) fault_ = place_ + key;
  }

  const Json& json_;
  std::string& fault_;
  std::string place_;
};

}  // namespace ensonify
