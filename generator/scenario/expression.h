// Arithmetic over the variables of a scenario.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace ensonify {

// A finite value, or the error with what is expected.
struct Evaluation {
  std::optional<double> value;
  std::string trouble;
};

// Returns the number that a name in the expression represents, or the error in it.
using NumberOfName = std::function<Evaluation(const std::string& name)>;

// Evaluates one expression in the syntax of muParser, without assignments.
Evaluation evaluated(std::string_view expression, const NumberOfName& number_of);

}  // namespace ensonify
