#include "scenario/key_facts.h"

#include <algorithm>
#include <string>

namespace ensonify {
namespace {

using PathFact = KeyFacts::PathFact;

// The rows of a key in a sorted list. Clang 14 does not compile std::ranges::equal_range.
template <class Row>
std::span<const Row> rows_of(std::span<const Row> rows, std::string_view key) {
  const auto first = std::ranges::lower_bound(rows, key, {}, &Row::key);
  return {first, std::ranges::upper_bound(first, rows.end(), key, {}, &Row::key)};
}

const PathFact* find_path(std::string_view path) {
  const auto& paths = key_facts().paths;
  const auto found = std::ranges::lower_bound(paths, path, {}, &PathFact::path);
  return found == paths.end() || found->path != path ? nullptr : &*found;
}

// Null if nothing is listed for the path.
const PathFact* fact_at(std::span<const std::string_view> path) {
  std::string listed;
  const PathFact* fact = nullptr;
  for (const std::string_view segment : path) {
    const bool is_item = fact != nullptr && (fact->is_list || fact->has_names);
    if (!listed.empty()) listed += '.';
    listed += is_item ? "*" : segment;
    fact = find_path(listed);
  }
  return fact;
}

}  // namespace

std::vector<std::string_view> excluded_by(std::string_view key) {
  std::vector<std::string_view> excluded;
  for (const auto& exclusion : rows_of(key_facts().exclusions, key)) {
    excluded.push_back(exclusion.other);
  }
  return excluded;
}

std::vector<std::string_view> excluded_by_value(std::string_view key, const Node& value) {
  std::vector<std::string_view> excluded;
  for (const auto& exclusion : rows_of(key_facts().value_exclusions, key)) {
    const bool holds = value.text == exclusion.word || find(value, exclusion.word) != nullptr;
    if (holds) excluded.push_back(exclusion.other);
  }
  return excluded;
}

bool names_file(std::string_view key) { return std::ranges::binary_search(key_facts().files, key); }

bool reads_whole_numbers(std::string_view path) {
  std::vector<std::string_view> segments;
  for (;;) {
    const std::size_t dot = path.find('.');
    segments.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) break;
    path.remove_prefix(dot + 1);
  }
  const PathFact* fact = fact_at(segments);
  return fact != nullptr && fact->is_integer;
}

bool holds_kind(std::span<const std::string_view> path) {
  const PathFact* fact = fact_at(path);
  return fact != nullptr && fact->is_kind;
}

bool holds_names(std::span<const std::string_view> path) {
  const PathFact* fact = fact_at(path);
  return fact != nullptr && fact->has_names;
}

}  // namespace ensonify
