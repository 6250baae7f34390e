// Arithmetic over the variables of a scenario.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace ensonify {

// A finite value, or what is wrong and what is accepted.
struct Evaluation {
  std::optional<double> value;
  std::string trouble;
};

// The number that a name of the expression stands for; else what is wrong with it.
using NumberOfName = std::function<Evaluation(const std::string& name)>;

// Of one expression in the syntax of muParser, without assignments.
Evaluation evaluated(std::string_view expression, const NumberOfName& number_of);

}  // namespace ensonify
