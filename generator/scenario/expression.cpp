#include "scenario/expression.h"

#include <cmath>

#include <fmt/format.h>
#include <muParser.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMostBytes = 1000;

std::string with_example(std::string trouble) {
  if (trouble.ends_with('.')) trouble.pop_back();
  return trouble + R"(; expected an expression as in "= 0.5 * depth + 1")";
}

}  // namespace

Evaluation evaluated(std::string_view expression, const NumberOfName& number_of) {
  if (expression.size() > kMostBytes) {
    return {std::nullopt,
            with_example(fmt::format("the expression is longer than {} bytes", kMostBytes))};
  }
  try {
    mu::Parser parser;
    parser.SetExpr(std::string(expression));
    const mu::varmap_type used = parser.GetUsedVar();  // a definition clears the parser's own copy
    for (const auto& name : used) {
      const Evaluation number = number_of(name.first);
      if (!number.value) return number;
      parser.DefineConst(name.first, *number.value);  // constants cannot be assigned to
    }
    const double value = parser.Eval();
    if (parser.GetNumResults() != 1)
      return {std::nullopt, with_example("the expression has several values")};
    if (!std::isfinite(value))
      return {std::nullopt, with_example("the result is not a finite number")};
    return {value, ""};
  } catch (const mu::ParserError& error) {
    return {std::nullopt, with_example(one_line(error.GetMsg()))};
  }
}

}  // namespace ensonify
