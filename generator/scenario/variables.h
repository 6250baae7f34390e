// Variables: `variables` at the top level holds named values and distributions. Other keys use them
// as `$name`, as `$name.key` into a map, or in an expression, `= 0.5 * name + 1`.
//
//   is_use  uses_variables     a scalar that stands for the value of a variable; anywhere in a tree
//   VariableTable              values by name
//   VariableUse  put_values    replaces uses by values
//   whole_variables            the variables that integer keys use
//   with_definitions           a tree before sampling, with distributions in place of uses
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

// In an entry with a count, the number of the copy; no variable can have this name.
inline constexpr std::string_view kIndex = "index";

// With or without quotes, since no text of a scenario begins with these characters.
bool is_use(const Node& node);
bool uses_variables(const Node& node);

// Empty if a variable cannot be sampled, which has been reported.
using VariableTable = std::map<std::string, std::optional<Node>, std::less<>>;

// A letter followed by letters, digits and underscores; otherwise an error, and false.
bool is_variable_name(Faults& faults, const Key& name, const std::string& path);

struct VariableUse {
  Place place;
  std::string name;
};

// The result of using variables. `wrong`: places of uses without a value, whose errors have been
// reported; `copied`: values put in place, up to the limit of `faults`.
struct UseReport {
  Faults& faults;
  std::vector<Place>& wrong;
  std::vector<VariableUse>& uses;
  std::size_t copied = 0;
};

// Replaces uses below a node at `path`, whose last key is `key`. In lists with counts, uses of the
// index of a copy stay while the table has no index. Errors: unknown variables, with the nearest
// name; uses as names and files; wrong expressions.
void put_values(Node& node, std::string_view key, const std::string& path,
                const VariableTable& table, UseReport& report);

// Paths such as variables.NAME, of variables that stand alone at an integer key.
std::set<std::string> whole_variables(const Node& root);

// The root without `variables`; uses in expressions stay, and so do wrong uses.
Node with_definitions(const Node& root, std::size_t most_values);

// Adds the variable that provides the value to each error from `first` on that is at a use of it.
void name_variables(const std::vector<VariableUse>& uses, std::size_t first, Faults& faults);

}  // namespace ensonify
