// Variables: the top level's `variables` holds values and distributions by name. Other keys use
// them as `$name`, as `$name.key` into a map, or in an expression, `= 0.5 * name + 1`.
//
//   is_use  uses_variables     a scalar that stands for the value of a variable; anywhere in a tree
//   VariableTable              values by name
//   VariableUse  put_values    the values in place of their uses
//   whole_variables            those that keys of integers use
//   with_definitions           a tree before it is drawn, with distributions in place of uses
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/faults.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

inline constexpr std::string_view kVariables = "variables";

// In an entry with a count, the number of the copy; no variable is called so.
inline constexpr std::string_view kIndex = "index";

// In quotes or not: no text of a scenario begins so.
bool is_use(const Node& node);
bool uses_variables(const Node& node);

// Nothing where a variable cannot be drawn, which has its fault.
using VariableTable = std::map<std::string, std::optional<Node>, std::less<>>;

// A letter, followed by letters, digits and underscores; a fault, and false, if it is none.
bool is_variable_name(Faults& faults, const Key& name, const std::string& path);

struct VariableUse {
  Place place;
  std::string name;
};

// What using variables leads to. `wrong`: places of uses without a value, whose faults are told;
// `copied`: values put in place, up to the limit of `faults`.
struct UseReport {
  Faults& faults;
  std::vector<Place>& wrong;
  std::vector<VariableUse>& uses;
  std::size_t copied = 0;
};

// Below a node at `path`, whose last key is `key`. The values stand where they are used; what uses
// the index of a copy stays in lists with counts while the table has none. Faults: unknown
// variables, with the nearest name; uses as names and files; wrong expressions.
void put_values(Node& node, std::string_view key, const std::string& path,
                const VariableTable& table, UseReport& report);

// Paths as in variables.NAME, of those that stand alone where an integer is read.
std::set<std::string> whole_variables(const Node& root);

// The root without `variables`; a use in an expression stays. What is wrong stays, too.
Node with_definitions(const Node& root, std::size_t most_values);

// Adds to each fault from `first` on that stands at a use which variable gives the value.
void name_variables(const std::vector<VariableUse>& uses, std::size_t first, Faults& faults);

}  // namespace ensonify
