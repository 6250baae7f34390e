// A comparison as text and as JSON.
//
//   comparison_table   a line per statistic, for a terminal
//   comparison_json    all numbers; docs/compare.md has the members
#pragma once

#include <string>

#include "compare/compare.h"

namespace ensonify {

std::string comparison_table(const Comparison& comparison);
std::string comparison_json(const Comparison& comparison, const std::string& real,
                            const std::string& simulated);

// With 3 significant digits; "-" for NaN.
std::string short_number(double value);

}  // namespace ensonify
