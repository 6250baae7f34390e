#include <fmt/format.h>

#include "sweep/conditions.h"
#include "sweep/sweep_file.h"

namespace ensonify {
namespace {

std::vector<double> variables_at(const SweepFile& sweep, const Point& point, std::size_t count) {
  std::vector<double> values;
  for (std::size_t g = 0; g < sweep.axes.size(); ++g) {
    for (const Axis& axis : sweep.axes[g].axes) {
      values.push_back(value_of(point, g, axis).number);
    }
  }
  if (values.size() < count) {
    values.push_back(static_cast<double>(point.seed.value_or(sweep.base_seed)));
  }
  return values;
}

// The `number`th of the product, the last axis but the seeds fastest.
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
  for (std::size_t g = 0; g < sweep.axes.size(); ++g) {
    for (const Axis& axis : sweep.axes[g].axes) {
      if (axis.name == name) return value_of(point, g, axis).label;
    }
  }
  return seed_text(sweep, point);
}

std::string with_all_axes(const SweepFile& sweep, const Point& point) {
  std::string name;
  const auto add = [&](const std::string& axis, const std::string& value) {
    name += fmt::format("{}{}={}", name.empty() ? "" : ",", axis, value);
  };
  for (std::size_t g = 0; g < sweep.axes.size(); ++g) {
    for (const Axis& axis : sweep.axes[g].axes) add(axis.name, value_of(point, g, axis).label);
  }
  if (!sweep.seeds.empty()) add("seed", seed_text(sweep, point));
  return name;
}

}  // namespace

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
    ENSONIFY_ASSERT(!conditions.add(condition.text));  // parse_sweep_file has looked at it
  }
  std::vector<Point> points;
  std::vector<bool> told(sweep.skip_if.size());
  for (std::size_t i = 0; i < sweep.product; ++i) {
    Point point = point_at(sweep, i);
    const Conditions::Answer answer = conditions.at(variables_at(sweep, point, names.size()));
    if (answer.no_value != Conditions::none && !told[answer.no_value]) {
      told[answer.no_value] = true;
      const Condition& condition = sweep.skip_if[answer.no_value];
      add_fault(faults, condition.place, condition.path,
                fmt::format("has no finite value, accepted is a condition that has one everywhere "
                            "(run {})",
                            name_of(sweep, point)));
    }
    if (answer.holds == Conditions::none) points.push_back(std::move(point));
  }
  if (faults.empty() && points.empty()) {
    add_fault(faults, sweep.skip_if.front().place, "skip_if",
              "leaves out every run, accepted are conditions that leave some");
  }
  if (!faults.empty()) return to_error(faults);
  return points;
}

const AxisValue& value_of(const Point& point, std::size_t group, const Axis& axis) {
  return axis.values[point.at[group]];
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
  for (std::size_t g = 0; g < sweep.axes.size(); ++g) {
    for (const Axis& axis : sweep.axes[g].axes) {
      const AxisValue& value = value_of(point, g, axis);
      settings.insert(settings.end(), value.settings.begin(), value.settings.end());
    }
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
