// Whether something was refused, and in which words.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "catch.h"
#include "core/error.h"

namespace ensonify::test {

// Of a Result or a Status: an error whose message holds `words`, of the kind where one is given.
// For CHECK, which then prints the message.
template <class Outcome>
bool is_refused(const Outcome& outcome, std::string_view words,
                std::optional<ErrorKind> kind = std::nullopt) {
  if (outcome) return false;
  UNSCOPED_INFO(outcome.error().message);
  return outcome.error().message.find(words) != std::string::npos &&
         (!kind || outcome.error().kind == *kind);
}

}  // namespace ensonify::test
