#include "scenario/variables.h"

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "scenario/distribution.h"
#include "scenario/expression.h"
#include "scenario/key_facts.h"
#include "scenario/reader.h"
#include "scenario/text.h"
#include "scenario/value_text.h"

namespace ensonify {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// "depth.upper" of $depth.upper; empty if the text is not a reference.
std::optional<std::string_view> referred(const Node& node) {
  if (node.kind != NodeKind::scalar || node.text.size() < 2 || node.text[0] != '$' ||
      !is_letter(node.text[1])) {
    return std::nullopt;
  }
  return std::string_view(node.text).substr(1);
}

bool is_expression(const Node& node) {
  return node.kind == NodeKind::scalar && node.text.starts_with('=');
}

std::vector<std::string_view> names_of(const VariableTable& table) {
  std::vector<std::string_view> names;
  for (const auto& variable : table) names.push_back(variable.first);
  return names;
}

std::string unknown(std::string_view name, const VariableTable& table) {
  const std::vector<std::string_view> names = names_of(table);
  const std::string known = names.empty() ? "expected one that is defined under variables"
                                          : "expected one of variables: " + joined(names);
  return fmt::format("no variable {}{}; {}", shown(name), hint(name, names), known);
}

// The variable that a reference names, and the keys into its value.
std::pair<std::string_view, std::string_view> split(std::string_view reference) {
  const std::size_t dot = reference.find('.');
  if (dot == std::string_view::npos) return {reference, ""};
  return {reference.substr(0, dot), reference.substr(dot + 1)};
}

// The value at a key path in a value; null if there is none.
const Node* within(const Node* node, std::string_view keys) {
  while (node != nullptr && !keys.empty()) {
    const auto [key, rest] = split(keys);
    node = node->kind == NodeKind::map ? find(*node, key) : nullptr;
    keys = rest;
  }
  return node;
}

std::optional<double> plain_number(const Node& node) {
  if (node.kind != NodeKind::scalar || node.quoted) return std::nullopt;
  if (classify_plain(node.text) != PlainKind::number) return std::nullopt;
  std::string_view text = node.text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

void give_up(const Node& node, const std::string& path, std::string text, UseReport& report) {
  if (!text.empty()) add_fault(report.faults, node.place, path, std::move(text));
  report.wrong.push_back(node.place);
}

// A node that uses the index of a copy waits until the copies exist.
bool waits_for_index(std::string_view name, const std::string& path, const VariableTable& table) {
  return name == kIndex && !table.contains(kIndex) &&
         is_counted_list(std::string_view(path).substr(0, path.find('.')));
}

void put_reference(Node& node, std::string_view reference, const std::string& path,
                   const VariableTable& table, UseReport& report) {
  const auto [name, keys] = split(reference);
  if (waits_for_index(name, path, table)) return;
  const auto found = table.find(name);
  if (found == table.end()) return give_up(node, path, unknown(name, table), report);
  if (!found->second) return give_up(node, path, "", report);
  const Node* value = within(&*found->second, keys);
  if (value == nullptr) {
    return give_up(node, path,
                   fmt::format("variables.{} has no key {}; expected a key of its value, {}", name,
                               shown(keys), shown(flow_text(*found->second))),
                   report);
  }
  report.copied += values_in(*value);
  if (report.copied > report.faults.limits.copied_values) {
    return give_up(node, path,
                   fmt::format("variables stand for more than {} values; expected fewer",
                               report.faults.limits.copied_values),
                   report);
  }
  report.uses.push_back({node.place, std::string(name)});
  const Place place = node.place;
  node = *value;
  node.place = place;
}

void put_expression(Node& node, const std::string& path, const VariableTable& table,
                    UseReport& report) {
  std::string used;
  bool is_told = false;  // whether the error of a variable has been reported already
  bool waits = false;
  const auto number_of = [&](const std::string& name) -> Evaluation {
    waits = waits || waits_for_index(name, path, table);
    if (waits) return {};
    const auto found = table.find(name);
    if (found == table.end()) return {std::nullopt, unknown(name, table)};
    is_told = !found->second.has_value();
    if (is_told) return {};
    used = name;
    const std::optional<double> value = plain_number(*found->second);
    if (value) return {value, ""};
    return {std::nullopt, fmt::format("variables.{} is {}; expected a number in an expression",
                                      name, shown(flow_text(*found->second)))};
  };
  const Evaluation result = evaluated(std::string_view(node.text).substr(1), number_of);
  if (waits) return;
  if (!result.value) return give_up(node, path, is_told ? "" : result.trouble, report);
  if (!used.empty()) report.uses.push_back({node.place, used});
  node.text = number(*result.value + 0.0);
  node.quoted = false;
}

// A value that keys the random numbers, or names an asset, must not differ between sequences.
std::string refusal(std::string_view key, const std::string& path) {
  if (is_head_key(path) || key == "name") {
    return "cannot be a variable, because it keys the random numbers; expected a plain value";
  }
  if (names_file(key)) {
    return "a file cannot be named by a variable; expected a path, or a variable for the map "
           "around "
           "it, as in `mesh: $hull` with `hull: {choice: [{file: a.obj}, {file: b.obj}]}`";
  }
  return "";
}

// Calls visit(scalar, path) for each use.
template <class Visit>
void for_each_use(const Node& node, const std::string& path, Visit&& visit) {
  if (is_use(node)) visit(node, path);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const Node& item = node.items[i];
    if (item.items.empty() && !is_use(item)) continue;
    const bool in_map = node.kind == NodeKind::map;
    for_each_use(item, joined_path(path, in_map ? node.keys[i].text : std::to_string(i)), visit);
  }
}

// All values that a reference may stand for in any sequence.
Node definition_of(const Node& node, std::string_view keys) {
  if (keys.empty()) return node;
  if (!is_distribution(node) || node.keys[0].text != "choice") {
    const Node* value = within(&node, keys);
    return value != nullptr ? *value : Node{};
  }
  Node choice = node;
  for (Node& alternative : choice.items[0].items) alternative = definition_of(alternative, keys);
  return choice;
}

void put_definitions(Node& node, const VariableTable& table, std::size_t& left) {
  if (const auto reference = referred(node)) {
    const auto [name, keys] = split(*reference);
    const auto found = table.find(name);
    if (found == table.end() || !found->second) return;
    Node definition = definition_of(*found->second, keys);
    const std::size_t size = values_in(definition);
    if (size > left) return;
    left -= size;
    const Place place = node.place;
    node = std::move(definition);
    node.place = place;
    return;
  }
  for (Node& item : node.items) put_definitions(item, table, left);
}

}  // namespace

bool is_use(const Node& node) { return referred(node).has_value() || is_expression(node); }

bool uses_variables(const Node& node) {
  return is_use(node) || std::any_of(node.items.begin(), node.items.end(), uses_variables);
}

bool is_variable_name(Faults& faults, const Key& name, const std::string& path) {
  constexpr std::string_view kOthers = "0123456789_";
  const std::string& text = name.text;
  const bool is_well = !text.empty() && text.size() <= kMaxNameBytes && is_letter(text[0]) &&
                       text != kIndex && std::all_of(text.begin(), text.end(), [&](char c) {
                         return is_letter(c) || kOthers.find(c) != std::string_view::npos;
                       });
  if (is_well) return true;
  add_fault(faults, name.place, path,
            fmt::format("{} is not a name for a variable; expected a letter followed by letters, "
                        "digits and underscores, and not `index`",
                        shown(text)));
  return false;
}

void put_values(Node& node, std::string_view key, const std::string& path,
                const VariableTable& table, UseReport& report) {
  if (is_use(node)) {
    std::string refused = refusal(key, path);
    if (!refused.empty()) return give_up(node, path, std::move(refused), report);
    if (const auto reference = referred(node)) {
      return put_reference(node, std::string(*reference), path, table, report);
    }
    return put_expression(node, path, table, report);
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    Node& item = node.items[i];
    if (item.kind == NodeKind::null || (item.kind == NodeKind::scalar && !is_use(item))) continue;
    const bool in_map = node.kind == NodeKind::map;
    const std::string segment = in_map ? node.keys[i].text : std::to_string(i);
    // A distribution stands for a value of the key above it.
    const bool is_keyed = in_map && !is_distribution(node);
    put_values(item, is_keyed ? segment : key, joined_path(path, segment), table, report);
  }
}

std::set<std::string> whole_variables(const Node& root) {
  std::set<std::string> whole;
  for_each_use(root, "", [&](const Node& use, const std::string& path) {
    const auto reference = referred(use);
    if (!reference || !reads_whole_numbers(without_choices(path))) return;
    whole.insert(joined_path(kVariables, *reference));
  });
  return whole;
}

Node with_definitions(const Node& root, std::size_t most_values) {
  Node copy = root;
  VariableTable table;
  if (const Node* variables = find(root, kVariables)) {
    for (std::size_t i = 0; i < variables->items.size() && i < variables->keys.size(); ++i) {
      Node definition = variables->items[i];
      put_definitions(definition, table, most_values);
      table.emplace(variables->keys[i].text, std::move(definition));
    }
    const auto at = find(copy, kVariables) - copy.items.data();
    copy.items.erase(copy.items.begin() + at);
    copy.keys.erase(copy.keys.begin() + at);
  }
  put_definitions(copy, table, most_values);
  return copy;
}

void name_variables(const std::vector<VariableUse>& uses, std::size_t first, Faults& faults) {
  const auto key = [](const Place& p) { return std::tuple(p.source, p.line, p.column); };
  std::map<std::tuple<int, int, int>, std::string> names;
  for (const VariableUse& use : uses) names.try_emplace(key(use.place), use.name);
  for (std::size_t i = first; i < faults.list.size(); ++i) {
    const auto use = names.find(key(faults.list[i].place));
    if (use == names.end()) continue;
    faults.list[i].text += fmt::format(" (from variables.{})", use->second);
  }
}

}  // namespace ensonify
