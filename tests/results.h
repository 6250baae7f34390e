// What calls return, for tests: what must have gone well, and what must fail in one way.
//
//   value_of      of a Result or an optional; the case ends with the error where there is none
//   require_ok    of a call whose value is not wanted
//   message_of    of the error, and nothing where there is none
//   lines_of      of a message that has several
//   joined_lines  the lines again, for what a failed assertion shows
//   contains      whether a text has a part
//   check_fails   a call ends with an error of this kind, whose message has all of these parts
#pragma once

#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "catch.h"
#include "core/error.h"

namespace ensonify {

template <class T>
T value_of(Result<T> result) {
  if (!result) FAIL(result.error().message);
  return std::move(*result);
}
template <class T>
T value_of(std::optional<T> value) {
  REQUIRE(value.has_value());
  return std::move(*value);
}

template <class Outcome>
std::string message_of(const Outcome& outcome) {
  return outcome.ok() ? std::string() : outcome.error().message;
}

template <class Outcome>
void require_ok(const Outcome& outcome) {
  INFO(message_of(outcome));
  REQUIRE(outcome.ok());
}

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

inline std::vector<std::string> lines_of(const std::string& message) {
  std::vector<std::string> lines;
  std::istringstream stream(message);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

inline std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

template <class Outcome>
void check_fails(const Outcome& outcome, std::initializer_list<std::string_view> parts) {
  REQUIRE_FALSE(outcome.ok());
  INFO(outcome.error().message);
  for (const std::string_view part : parts) {
    INFO(part);
    CHECK(contains(outcome.error().message, part));
  }
}
template <class Outcome>
void check_fails(const Outcome& outcome, ErrorKind kind,
                 std::initializer_list<std::string_view> parts = {}) {
  check_fails(outcome, parts);
  CHECK(outcome.error().kind == kind);
}

}  // namespace ensonify
