// list_keys FILE: writes the source that defines key_facts(). Run by the build.
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include "core/error.h"
#include "scenario/key_catalogue.h"
#include "scenario/key_facts.h"

namespace ensonify {

// The scenario library is linked into this program too, which never reads a scenario.
const KeyFacts& key_facts() {
  ENSONIFY_ASSERT(false);
  static const KeyFacts none;
  return none;
}

namespace {

using Pair = std::pair<std::string, std::string>;

struct Collected {
  std::set<Pair> exclusions;
  std::set<Pair> together;  // in some map
  std::set<std::tuple<std::string, std::string, std::string>> value_exclusions;
  std::set<std::string> files;
  std::map<std::string, std::string> paths;  // with the values of PathFact
};

void exclude(Collected& collected, const std::string& one, const std::string& other) {
  collected.exclusions.emplace(one, other);
  collected.exclusions.emplace(other, one);
}

// Exclusions have no path, so keys that stand together in some map exclude each other in none:
// sonar and camera are one instrument each of a rig, and both sections of a scenario.
void collect_together(Collected& collected, const KeyNode& map) {
  std::set<Pair> apart;
  for (const KeyGroup& group : map.groups) {
    for (const std::string& one : group.keys) {
      for (const std::string& other : group.keys) apart.emplace(one, other);
    }
  }
  for (const KeyExclusion& exclusion : map.exclusions) apart.emplace(exclusion.key, exclusion.by);
  for (const KeyNode& one : map.keys) {
    for (const KeyNode& other : map.keys) {
      const bool is_apart =
          apart.contains({one.key, other.key}) || apart.contains({other.key, one.key});
      if (!is_apart) collected.together.emplace(one.key, other.key);
    }
  }
}

void collect_path(Collected& collected, const KeyNode& node, const std::string& path) {
  const bool is_integer = node.type == ValueType::integer;
  if (!node.is_list && !node.has_names && !node.is_kind && !is_integer) return;
  collected.paths.emplace(
      path, fmt::format("{}, {}, {}, {}", node.is_list, node.has_names, node.is_kind, is_integer));
}

void collect(Collected& collected, const KeyNode& map, const std::string& prefix) {
  for (const KeyGroup& group : map.groups) {
    for (const std::string& one : group.keys) {
      for (const std::string& other : group.keys) {
        if (one != other) exclude(collected, one, other);
      }
    }
  }
  for (const auto& [key, by, word] : map.exclusions) {
    if (word.empty()) {
      exclude(collected, key, by);
    } else {
      collected.value_exclusions.emplace(by, word, key);
    }
  }
  for (const KeyNode& node : map.keys) {
    const std::string path = prefix + node.key;
    if (node.type == ValueType::file) collected.files.emplace(node.key);
    collect_path(collected, node, path);
    collect(collected, node, path + ".");
  }
  collect_together(collected, map);
}

std::string source_of(const Collected& collected) {
  std::string text =
      "// Written by list_keys of generator/scenario.\n"
      "#include \"scenario/key_facts.h\"\n\nnamespace ensonify {\nnamespace {\n\n"
      "constexpr KeyFacts::Exclusion kExclusions[] = {\n";
  for (const auto& [key, other] : collected.exclusions) {
    if (collected.together.contains({key, other})) continue;
    text += fmt::format("    {{\"{}\", \"{}\"}},\n", key, other);
  }
  text += "};\n\nconstexpr KeyFacts::ValueExclusion kValueExclusions[] = {\n";
  for (const auto& [key, word, other] : collected.value_exclusions) {
    text += fmt::format("    {{\"{}\", \"{}\", \"{}\"}},\n", key, word, other);
  }
  text += "};\n\nconstexpr std::string_view kFiles[] = {\n";
  for (const std::string& key : collected.files) text += fmt::format("    \"{}\",\n", key);
  text += "};\n\nconstexpr KeyFacts::PathFact kPaths[] = {\n";
  for (const auto& [path, values] : collected.paths) {
    text += fmt::format("    {{\"{}\", {}}},\n", path, values);
  }
  text +=
      "};\n\nconstexpr KeyFacts kFacts{kExclusions, kValueExclusions, kFiles, kPaths};\n\n"
      "}  // namespace\n\nconst KeyFacts& key_facts() { return kFacts; }\n\n"
      "}  // namespace ensonify\n";
  return text;
}

}  // namespace
}  // namespace ensonify

int main(int count, char** arguments) {
  if (count != 2) return 2;
  ensonify::Collected collected;
  ensonify::collect(collected, ensonify::key_tree(), "");
  std::ofstream file(arguments[1], std::ios::binary);
  file << ensonify::source_of(collected);
  file.close();
  if (file) return 0;
  std::perror(arguments[1]);
  return 1;
}
