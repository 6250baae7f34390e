#include "scenario/drawn_sections.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "scenario/distribution.h"
#include "scenario/key_facts.h"
#include "scenario/merge.h"
#include "scenario/sections.h"
#include "scenario/text.h"
#include "scenario/value_text.h"
#include "scenario/variables.h"

namespace ensonify {
namespace {

// Calls visit(scalar, path) for each input file that the tree names; `key` is the last key above
// it.
template <class AnyNode, class Visit>
void for_each_file(AnyNode& node, std::string_view key, const std::string& path, Visit&& visit) {
  if (node.kind == NodeKind::scalar && names_file(key) && !is_use(node)) visit(node, path);
  const bool drawn = is_distribution(node);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool in_map = node.kind == NodeKind::map;
    const std::string segment = in_map ? node.keys[i].text : std::to_string(i);
    const std::string inner = joined_path(path, segment);
    if (!drawn) {
      const bool keyed = in_map && key != "parts";  // the keys of `parts` are names
      for_each_file(node.items[i], keyed ? segment : "", inner, visit);
      continue;
    }
    for (std::size_t k = 0; k < node.items[i].items.size(); ++k) {
      for_each_file(node.items[i].items[k], key, joined_path(inner, std::to_string(k)), visit);
    }
  }
}

// Merges the preset's keys under the section's own, as reading the section would. A preset whose
// keys depend on a sampled range stays a name, so that the range of each sequence selects them.
Node with_preset(const Node& sonar) {
  const Node* name = sonar.kind == NodeKind::map ? find(sonar, "preset") : nullptr;
  if (name == nullptr || name->kind != NodeKind::scalar) return sonar;
  for (std::size_t i = 0; i < sonar_presets().size(); ++i) {
    if (sonar_presets()[i].name != name->text) continue;
    const Node* range = find(sonar, "range_max_m");
    const bool is_drawn = range != nullptr && (is_distribution(*range) || is_use(*range));
    if (is_drawn && preset_depends_on_range(i)) return sonar;
    return without(merge_over(preset_tree(i, sonar), sonar), "preset");
  }
  return sonar;
}

// The sonars of a rig, each with its preset.
Node filled_rig(Node rig) {
  if (rig.kind != NodeKind::list) return rig;
  for (Node& instrument : rig.items) {
    Node* sonar = instrument.kind == NodeKind::map ? find(instrument, "sonar") : nullptr;
    if (sonar != nullptr) *sonar = with_preset(*sonar);
  }
  return rig;
}

Node filled(const std::string& key, const Node& tree) {
  if (key == "sonar") return with_preset(tree);
  return key == "rig" ? filled_rig(tree) : tree;
}

}  // namespace

std::shared_ptr<const DrawnSections> keep_drawn_sections(const Node& root,
                                                         const InputFolder& input) {
  auto sections = std::make_shared<DrawnSections>();
  for (std::size_t i = 0; i < root.items.size(); ++i) {
    const std::string& key = root.keys[i].text;
    const Node& tree = root.items[i];
    if (!holds_distribution(tree) && !has_counts(key, tree) && !uses_variables(tree) &&
        key != kVariables) {
      continue;
    }
    DrawnSection section{key, filled(key, tree)};
    for_each_file(section.tree, key, key, [&](Node& file, const std::string& path) {
      const auto found = (input.folder / file.text).lexically_normal();
      std::error_code error;
      if (!std::filesystem::is_regular_file(found, error)) {
        add_fault(input.faults, file.place, path,
                  fmt::format("{} does not exist; expected a readable file in every alternative",
                              shown(file.text)));
      }
      file.text = found.string();
      file.quoted = true;
    });
    sections->list.push_back(std::move(section));
  }
  if (sections->list.empty()) return nullptr;
  return sections;
}

const Node* drawn_section(const Scenario& scenario, std::string_view key) {
  if (!scenario.drawn_sections) return nullptr;
  for (const DrawnSection& section : scenario.drawn_sections->list) {
    if (section.key == key) return &section.tree;
  }
  return nullptr;
}

std::string section_text(std::string_view key, const Node& tree, const NameFile& name_file) {
  Node named = tree;
  for_each_file(named, key, "", [&](Node& file, const std::string&) {
    file.text = name_file(file.text);
    file.quoted = true;
  });
  std::string text = fmt::format("{}:", key);
  if (named.items.empty() || is_distribution(named)) return text + " " + flow_text(named) + "\n";
  text += "\n";
  for (std::size_t i = 0; i < named.items.size(); ++i) {
    const bool map = named.kind == NodeKind::map;
    const std::string head =
        map ? scalar_text(named.keys[i].text, named.keys[i].quoted) + ":" : "-";
    text += fmt::format("  {} {}\n", head, flow_text(named.items[i]));
  }
  return text;
}

}  // namespace ensonify
