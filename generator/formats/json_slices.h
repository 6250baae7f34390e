// Splits JSON text in place, for long lines of our own files whose values are passed on unchanged.
// Copies nothing and does not parse numbers and strings.
//
//   json_members   {"key": value, ...} to keys and texts of values
//   json_elements  [value, ...] to texts of values
//   JsonMembers    look-up by key
#pragma once

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace ensonify {

struct JsonMembers {
  std::vector<std::pair<std::string_view, std::string_view>> all;

  // Empty if there is no member with that key.
  std::string_view at(std::string_view key) const;
};

// Keys without their quotes, as they are written. None if the text is not exactly one object with
// balanced brackets and quotes.
std::optional<JsonMembers> json_members(std::string_view object);

// The same of an array.
std::optional<std::vector<std::string_view>> json_elements(std::string_view array);

}  // namespace ensonify
