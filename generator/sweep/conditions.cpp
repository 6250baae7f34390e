#include "sweep/conditions.h"

#include <muParser.h>
#include <algorithm>
#include <cfenv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "core/error.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

double negation(double value) { return value == 0 ? 1 : 0; }

// Muparser would set the variable.
bool assigns(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool doubled = i + 1 < text.size() && text[i + 1] == '=';
    const bool compares = i > 0 && std::string_view("<>!").find(text[i - 1]) != std::string::npos;
    if (!doubled && !compares) return true;
    if (doubled) ++i;
  }
  return false;
}

std::string trouble_of(const mu::ParserError& error, const std::vector<std::string>& names) {
  const std::vector<std::string_view> known(names.begin(), names.end());
  if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN) {
    return fmt::format("{} is not known here{}, accepted are numbers, {} and muparser's functions",
                       shown(error.GetToken()), hint(error.GetToken(), known), joined(known));
  }
  std::string text = one_line(error.GetMsg());
  if (text.ends_with('.')) text.pop_back();
  return text + "; accepted is a condition as in range_max_m > 10 && frequency_hz < 5e5";
}

}  // namespace

struct Conditions::Impl {
  std::vector<std::string> names;
  std::vector<double> values;  // what the parsers' variables refer to
  std::vector<std::unique_ptr<mu::Parser>> parsers;
};

Conditions::Conditions(std::vector<std::string> names) : impl_(std::make_unique<Impl>()) {
  impl_->values.resize(names.size(), 1);
  impl_->names = std::move(names);
}

Conditions::~Conditions() = default;

std::optional<std::string> Conditions::add(const std::string& text) {
  if (assigns(text)) return "a single = would set a value, accepted is == to compare";
  auto parser = std::make_unique<mu::Parser>();
  try {
    parser->DefineInfixOprt("!", negation);
    for (std::size_t i = 0; i < impl_->names.size(); ++i) {
      parser->DefineVar(impl_->names[i], &impl_->values[i]);
    }
    parser->SetExpr(text);
    parser->Eval();
    if (parser->GetNumResults() != 1) return "several values, accepted is one condition";
  } catch (const mu::ParserError& error) {
    return trouble_of(error, impl_->names);
  }
  impl_->parsers.push_back(std::move(parser));
  return std::nullopt;
}

Conditions::Answer Conditions::at(std::span<const double> values) {
  ENSONIFY_ASSERT(values.size() == impl_->values.size());
  std::copy(values.begin(), values.end(), impl_->values.begin());
  for (std::size_t i = 0; i < impl_->parsers.size(); ++i) {
    // A division by zero inside a comparison would go unseen.
    std::feclearexcept(FE_ALL_EXCEPT);
    double value = std::nan("");
    try {
      value = impl_->parsers[i]->Eval();
    } catch (const mu::ParserError&) {  // where muparser looks itself
    }
    const bool sound = std::fetestexcept(FE_INVALID | FE_DIVBYZERO) == 0;
    if (!sound || !std::isfinite(value)) return {none, i};
    if (value != 0) return {i, none};
  }
  return {};
}

}  // namespace ensonify
