// Members of a JSON object, written and read by the same list: a template that lists them in order
// takes either class.
//
//   MemberWriter  MemberReader   io("key", value)   numbers, texts, lists, pairs of pings
//                                io.word            an enumeration by name_of
//                                io.said            what follows from other members; only written
//                                io.group           an object
//                                io.group_if        ... or null where there is none
//                                io.flag_or_null  io.flag   ... if this is on; else null, or no
//                                member; read: whether it is there
//                                io.optional  io.maybe   ... of an optional; else null, or no
//                                member
//                                io.list            objects, one for each element
//                                io.number  io.part   keys that a struct lists (core/keys.h)
//
// The reader never throws. A member that is absent, null or of the wrong kind leaves its value
// unchanged; fault() names the first of the wrong kind. Private to dataset/.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
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
inline Json value_json(const Vec3& v) { return json_of(v); }
inline Json value_json(const Quat& q) { return Json::array({q.w, q.x, q.y, q.z}); }
inline Json value_json(const PulseTableRow& row) {
  return Json::array({row.frequency_hz, row.amplitude, row.phase_rad});
}
inline Json value_json(ClassKind kind) { return name_of(kind); }
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
inline bool take_value(const Json& json, Vec3& v) {
  std::array<double, 3> found{};
  const bool taken = take_value(json, found);
  if (taken) v = {found[0], found[1], found[2]};
  return taken;
}
inline bool take_value(const Json& json, Quat& q) {
  std::array<double, 4> found{};
  const bool taken = take_value(json, found);
  if (taken) q = {found[0], found[1], found[2], found[3]};
  return taken;
}
inline bool take_value(const Json& json, PulseTableRow& row) {
  std::array<double, 3> found{};
  const bool taken = take_value(json, found);
  if (taken) row = {found[0], found[1], found[2]};
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

// Scenarios and sequence.json share these keys. Only scenarios have rules.
template <class Io>
class KeyedMembers {
 public:
  template <class T>
  void number(const KeyText& text, T& value, const NumberRange&, Rule = {}) {
    self()(std::string(text.key).c_str(), value);
  }
  template <class T, class Each>
  void part(const KeyText& text, T& value, Each each) {
    self().optional(std::string(text.key).c_str(), value, each);
  }

 private:
  Io& self() { return static_cast<Io&>(*this); }
};

class MemberWriter : public KeyedMembers<MemberWriter> {
 public:
  static constexpr bool kWrites = true;
  explicit MemberWriter(Json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, const T& value) {
    json_[key] = value_json(value);
  }
  // [first, last).
  void pings(const std::uint32_t& first, const std::uint32_t& last) {
    json_["pings"] = Json::array({first, last});
  }
  template <class T>
  void word(const char* key, const T& value, T) {
    json_[key] = name_of(value);
  }
  void said(const char* key, Json value) { json_[key] = std::move(value); }

  template <class Use>
  void group(const char* key, Use use) {
    json_[key] = object_of(use);
  }
  template <class Use>
  void group_if(const char* key, bool is_there, Use use) {
    json_[key] = is_there ? object_of(use) : Json(nullptr);
  }
  template <class Use>
  void flag(const char* key, const bool& on, Use use) {
    if (on) group(key, use);
  }
  template <class Use>
  void flag_or_null(const char* key, const bool& on, Use use) {
    group_if(key, on, use);
  }
  template <class T, class Use>
  void optional(const char* key, const std::optional<T>& value, Use use) {
    group_if(key, value.has_value(), [&](MemberWriter& io) { use(io, *value); });
  }
  template <class T, class Use>
  void maybe(const char* key, const std::optional<T>& value, Use use) {
    if (value) optional(key, value, use);
  }
  template <class T, class Use>
  void list(const char* key, const std::vector<T>& values, Use use) {
    Json items = Json::array();
    for (const T& value : values) {
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

class MemberReader : public KeyedMembers<MemberReader> {
 public:
  static constexpr bool kWrites = false;
  // Both must outlive it. `fault` gets the path of the first member of a wrong kind.
  MemberReader(const Json& json, std::string& fault, std::string place = "")
      : json_(json), fault_(fault), place_(std::move(place)) {}

  const Json& json() const { return json_; }

  template <class T>
  void operator()(const char* key, T& value) {
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
  template <class T>
  void word(const char* key, T& value, T last) {
    std::string name;
    (*this)(key, name);
    for (int i = 0; i <= static_cast<int>(last); ++i) {
      if (name == name_of(static_cast<T>(i))) value = static_cast<T>(i);
    }
  }
  template <class T>
  void said(const char*, const T&) {}

  template <class Use>
  void group(const char* key, Use use) {
    const Json* found = there(key);
    if (found == nullptr) return;
    if (!found->is_object()) return refuse(key);
    MemberReader io(*found, fault_, place_ + key + ".");
    use(io);
  }
  template <class Use>
  void group_if(const char* key, bool, Use use) {
    group(key, use);
  }
  template <class Use>
  void flag(const char* key, bool& on, Use use) {
    group(key, [&](MemberReader& io) {
      on = true;
      use(io);
    });
  }
  template <class Use>
  void flag_or_null(const char* key, bool& on, Use use) {
    flag(key, on, use);
  }
  template <class T, class Use>
  void optional(const char* key, std::optional<T>& value, Use use) {
    group(key, [&](MemberReader& io) { use(io, value.emplace()); });
  }
  template <class T, class Use>
  void maybe(const char* key, std::optional<T>& value, Use use) {
    optional(key, value, use);
  }
  template <class T, class Use>
  void list(const char* key, std::vector<T>& values, Use use) {
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
