#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <string_view>

#include "core/error.h"
#include "scenario/text.h"
#include "sweep/sweep_file.h"

namespace ensonify {
namespace {

double negation(double value) { return value == 0 ? 1 : 0; }

// In muParser a single = would set the variable.
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
    return fmt::format("{} is not known here{}; expected numbers, {} and the functions of muParser",
                       shown(error.GetToken()), hint(error.GetToken(), known), joined(known));
  }
  std::string text = one_line(error.GetMsg());
  if (text.ends_with('.')) text.pop_back();
  return text + "; expected a condition such as range_max_m > 10 && frequency_hz < 5e5";
}

std::vector<double> variables_at(const SweepFile& sweep, const Point& point, std::size_t count) {
  std::vector<double> values;
  for (const PointValue& at : values_of(sweep, point)) values.push_back(at.value.number);
  if (values.size() < count) {
    values.push_back(static_cast<double>(point.seed.value_or(sweep.base_seed)));
  }
  return values;
}

// Point `number` of the product, in which the last axis varies fastest, apart from the seeds.
Point point_at(const SweepFile& sweep, std::size_t number) {
  Point point;
  if (!sweep.seeds.empty()) {
    point.seed = sweep.seeds[number % sweep.seeds.size()];
    number /= sweep.seeds.size();
  }
  point.at.resize(sweep.axes.size());
  for (std::size_t g = sweep.axes.size(); g-- > 0;) {
    const std::size_t count = sweep.axes[g].axes[0].values.size();
    point.at[g] = number % count;
    number /= count;
  }
  return point;
}

std::string seed_text(const SweepFile& sweep, const Point& point) {
  return std::to_string(point.seed.value_or(sweep.base_seed));
}

std::string text_of(const SweepFile& sweep, const Point& point, const std::string& name) {
  for (const PointValue& at : values_of(sweep, point)) {
    if (at.axis.name == name) return at.value.label;
  }
  return seed_text(sweep, point);
}

std::string with_all_axes(const SweepFile& sweep, const Point& point) {
  std::string name;
  const auto add = [&](const std::string& axis, const std::string& value) {
    name += fmt::format("{}{}={}", name.empty() ? "" : ",", axis, value);
  };
  for (const PointValue& at : values_of(sweep, point)) add(at.axis.name, at.value.label);
  if (!sweep.seeds.empty()) add("seed", seed_text(sweep, point));
  return name;
}

}  // namespace

struct Conditions::Impl {
  std::vector<std::string> names;
  std::vector<double> values;  // which the variables of the parsers refer to
  std::vector<std::unique_ptr<mu::Parser>> parsers;
};

Conditions::Conditions(std::vector<std::string> names) : impl_(std::make_unique<Impl>()) {
  impl_->values.resize(names.size(), 1);
  impl_->names = std::move(names);
}

Conditions::~Conditions() = default;

std::optional<std::string> Conditions::add(const std::string& text) {
  if (assigns(text)) return "a single = would set a value; expected == for a comparison";
  auto parser = std::make_unique<mu::Parser>();
  try {
    parser->DefineInfixOprt("!", negation);
    for (std::size_t i = 0; i < impl_->names.size(); ++i) {
      parser->DefineVar(impl_->names[i], &impl_->values[i]);
    }
    parser->SetExpr(text);
    parser->Eval();
    if (parser->GetNumResults() != 1) return "the text has several values; expected one condition";
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
    // A division by zero inside a comparison would not show in its result.
    std::feclearexcept(FE_ALL_EXCEPT);
    double value = std::nan("");
    try {
      value = impl_->parsers[i]->Eval();
    } catch (const mu::ParserError&) {  // muParser checks some operations itself
    }
    const bool sound = std::fetestexcept(FE_INVALID | FE_DIVBYZERO) == 0;
    if (!sound || !std::isfinite(value)) return {none, i};
    if (value != 0) return {i, none};
  }
  return {};
}

std::vector<std::string> variable_names(const SweepFile& sweep) {
  std::vector<std::string> names;
  bool seed_is_axis = false;
  for (const AxisGroup& group : sweep.axes) {
    for (const Axis& axis : group.axes) {
      names.push_back(axis.name);
      seed_is_axis = seed_is_axis || axis.name == "seed";
    }
  }
  if (!seed_is_axis) names.emplace_back("seed");
  return names;
}

Result<std::vector<Point>> points_of(const SweepFile& sweep) {
  const std::vector<std::string> names = variable_names(sweep);
  Conditions conditions(names);
  Faults faults;
  for (const std::string& label : sweep.sources) add_source(faults, label);
  for (const Condition& condition : sweep.skip_if) {
    ENSONIFY_ASSERT(!conditions.add(condition.text));  // parse_sweep_file has checked it
  }
  std::vector<Point> points;
  std::vector<bool> told(sweep.skip_if.size());
  for (std::size_t i = 0; i < sweep.product; ++i) {
    Point point = point_at(sweep, i);
    const Conditions::Answer answer = conditions.at(variables_at(sweep, point, names.size()));
    if (answer.no_value != Conditions::none && !told[answer.no_value]) {
      told[answer.no_value] = true;
      const Condition& condition = sweep.skip_if[answer.no_value];
      add_fault(
          faults, condition.place, condition.path,
          fmt::format(
              "has no finite value for run {}; expected a condition with a value for every run",
              name_of(sweep, point)));
    }
    if (answer.holds == Conditions::none) points.push_back(std::move(point));
  }
  if (faults.empty() && points.empty()) {
    add_fault(faults, sweep.skip_if.front().place, "skip_if",
              "skips every run; expected conditions that keep some runs");
  }
  if (!faults.empty()) return to_error(faults);
  return points;
}

std::vector<PointValue> values_of(const SweepFile& sweep, const Point& point) {
  std::vector<PointValue> values;
  for (std::size_t g = 0; g < sweep.axes.size(); ++g) {
    for (const Axis& axis : sweep.axes[g].axes) values.push_back({axis, axis.values[point.at[g]]});
  }
  return values;
}

std::string name_of(const SweepFile& sweep, const Point& point) {
  if (sweep.run_name.empty()) return with_all_axes(sweep, point);
  std::string name;
  for (const NamePiece& piece : sweep.run_name) {
    name += piece.is_value ? text_of(sweep, point, piece.text) : piece.text;
  }
  return name;
}

std::vector<Setting> settings_of(const SweepFile& sweep, const Point& point) {
  std::vector<Setting> settings;
  for (const auto& [axis, value] : values_of(sweep, point)) {
    settings.insert(settings.end(), value.settings.begin(), value.settings.end());
  }
  if (point.seed) {
    Node node;
    node.kind = NodeKind::scalar;
    node.place = sweep.seeds_place;
    node.text = std::to_string(*point.seed);
    settings.push_back({"seed", node.place, std::move(node)});
  }
  return settings;
}

}  // namespace ensonify
