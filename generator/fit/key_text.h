// Keys of a fit as words.
//
//   parse_key   PATH=LOW:HIGH or PATH=LOW:HIGH:log, of the command line
//   key_text    the shortest text of a value that reads back
#pragma once

#include <string>

#include "core/error.h"
#include "fit/search.h"

namespace ensonify {

// Error (usage): other words, low not below high, or log with a bound that is not above 0.
Result<FitKey> parse_key(const std::string& text);

std::string key_text(double value);

}  // namespace ensonify
