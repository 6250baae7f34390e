// How a struct lists its keys once. A template NAME_keys(io, value) names each key with its
// meaning, its variable and its valid values, in the order of the files. `io` reads or writes
// scenarios (scenario/fields.h) or sequence.json (dataset/json_members.h).
//
//   KeyText                                   a key and its meaning, for the schema and the docs
//   Need  Rule  kRequired  useless_if  written_if   the conditions of one key
//   NumberRange  from_to  above_up_to         valid numbers
//   OneOrMore                                 a number or a list of them
//   kMaxLengthM  kLength  kLevelDb
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ensonify {

// A key with its title and meaning in the schema and in docs/scenario_keys.md. A reader needs only
// the key.
struct KeyText {
  std::string_view key;
  std::string_view title = {};
  std::string_view meaning = {};  // ends with "left out: ..." if no value describes that
  std::string_view unit = {};     // if the end of the key does not imply it

  constexpr KeyText(const char* name) : key(name) {}
  constexpr KeyText(std::string_view name) : key(name) {}
  KeyText(const std::string& name) : key(name) {}
  constexpr KeyText(std::string_view name, std::string_view heading, std::string_view text,
                    std::string_view unit_text = {})
      : key(name), title(heading), meaning(text), unit(unit_text) {}
};

enum class Need { optional, required };

struct Rule {
  Need need = Need::optional;
  std::string_view unless = {};   // required only if this key, here or farther up, is not given
  bool written = true;            // whether the resolved text holds the key
  bool has_default = true;        // whether the variable holds the value of a key left out
  bool in_lines = false;          // in the text each key or item has a line of its own
  std::string_view useless = {};  // if not empty, the reason why the key has no effect here
};
inline constexpr Rule kRequired{.need = Need::required};

constexpr Rule useless_if(bool useless, std::string_view why, Rule rule = {}) {
  if (useless) rule.useless = why;
  return rule;
}
constexpr Rule written_if(bool written, Rule rule = {}) {
  rule.written = written;
  return rule;
}

struct NumberRange {
  double low = 0, high = 0;
  bool low_excluded = false;
};
constexpr NumberRange from_to(double low, double high) { return {low, high, false}; }
constexpr NumberRange above_up_to(double low, double high) { return {low, high, true}; }

// Written as a number if there is one, as a list if there are several. Empty: left out, null in
// files.
struct OneOrMore {
  std::vector<double> values;
};

// In meters: far beyond any sonar, and small enough that squares stay exact.
inline constexpr double kMaxLengthM = 1e7;

inline constexpr NumberRange kLength = above_up_to(0, kMaxLengthM);
inline constexpr NumberRange kLevelDb = from_to(-300, 400);

}  // namespace ensonify
