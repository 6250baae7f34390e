// The axes of a sweep and their values.
//
//   AxisValue  Axis  AxisGroup     a value of an axis; axes that vary together
//   parse_axes                     the list `axes` of a sweep file
//   linear_values  log_values  uniform_values  log_uniform_values
//   is_axis_name                   letters, digits and _
//   json_of_node  plain_text       a value as JSON on one line; a scalar as it was written
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/merge.h"
#include "scenario/reader.h"

namespace ensonify {

struct AxisValue {
  std::string label;              // in names of runs
  std::string json;               // in plan.jsonl
  double number = 0;              // in conditions
  std::vector<Setting> settings;  // settings of the base
};

struct Axis {
  std::string name;
  Place place;
  std::vector<AxisValue> values;  // at least one
};

// One axis, or the axes of a zip, which have equally many values.
struct AxisGroup {
  std::vector<Axis> axes;
};

// The limit on values of one axis and on points of the product.
inline constexpr int kMaxAxisValues = 100'000;

// `seed` keys the random values. Errors: wrong axes, which are skipped; names and key paths that
// two axes share.
std::vector<AxisGroup> parse_axes(Faults& faults, const Value& list, std::uint64_t seed);

// From a to b, both included; `count` = 1 gives only a. Rounded to 15 significant digits.
std::vector<double> linear_values(double a, double b, int count);

// The same with equal ratios; a, b > 0. Values in between are rounded to 6 significant digits, so
// that machines whose logarithms differ in the last bit agree and people can type the values.
std::vector<double> log_values(double a, double b, int count);

// Random values with a <= b, rounded to 6 significant digits. Value i depends only on the key and
// on i, so that a larger count only adds values. With `whole`, all integers from a to b are equally
// likely.
std::vector<double> uniform_values(double a, double b, int count, std::uint64_t key,
                                   bool whole = false);
std::vector<double> log_uniform_values(double a, double b, int count, std::uint64_t key);

bool is_axis_name(std::string_view name);

std::string json_of_node(const Node& node);
std::string plain_text(const Node& node);

}  // namespace ensonify
