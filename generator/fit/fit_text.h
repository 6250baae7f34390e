// Keys of a fit as words, and a fit as text, JSON and as an instrument card.
//
//   parse_key   PATH=LOW:HIGH or PATH=LOW:HIGH:log, of the command line
//   key_text    the shortest text of a value that reads back
//   FitFacts
//   fit_table  fit_json
//   fit_card    the keys as YAML that a scenario may hold, with their intervals
#pragma once

#include <string>
#include <vector>

#include "core/error.h"
#include "fit/search.h"

namespace ensonify {

// Error (usage): other words, low not below high, or log with a bound that is not above 0.
Result<FitKey> parse_key(const std::string& text);

std::string key_text(double value);

// What was fitted to what.
struct FitFacts {
  std::string scenario, recording;  // as the user named them
  std::size_t pings = 0, blocks = 0;
  std::vector<std::string> moment_names;
  FitTarget target;
};

std::string fit_table(std::span<const FitKey> keys, const Fit& fit);
std::string fit_json(std::span<const FitKey> keys, const Fit& fit, const FitFacts& facts);
std::string fit_card(std::span<const FitKey> keys, const Fit& fit, const FitFacts& facts);

}  // namespace ensonify
