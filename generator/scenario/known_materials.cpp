#include "scenario/known_materials.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "scenario/merge.h"
#include "scenario/preset_files.h"
#include "scenario/scenario.h"

namespace ensonify {
namespace {

constexpr std::string_view kMaterials = "materials", kMaterial = "material", kParts = "parts";

// A material of configs/materials.yaml: a key at the start of a line, with the lines below it that
// are indented. Each is parsed when it is first named.
struct KnownMaterial {
  std::string name;
  std::string text;
  std::once_flag once;
  Node tree;
};

std::deque<KnownMaterial> split_materials(std::string_view yaml) {
  std::deque<KnownMaterial> found;
  while (!yaml.empty()) {
    const std::size_t newline = yaml.find('\n');
    const std::string_view line = yaml.substr(0, newline == yaml.npos ? newline : newline + 1);
    yaml.remove_prefix(line.size());
    if (line.starts_with('#') || line == "\n") continue;
    if (!line.starts_with(' ')) found.emplace_back().name = line.substr(0, line.find(':'));
    found.back().text += line;
  }
  return found;
}

std::deque<KnownMaterial>& built_in() {
  static std::deque<KnownMaterial> known = split_materials(materials_yaml());
  return known;
}

// Null if there is no such material.
const Node* find_known(std::string_view name) {
  const auto found = std::ranges::find(built_in(), name, &KnownMaterial::name);
  if (found == built_in().end()) return nullptr;
  std::call_once(found->once, [&] {
    Faults faults;
    auto read = read_yaml_map(found->text, add_source(faults, found->name), faults);
    ENSONIFY_ASSERT(read && faults.empty() && read->items.size() == 1);
    found->tree = std::move(read->items.front());
  });
  return &found->tree;
}

// Errors in the keys of a preset are reported where the scenario names it.
void set_place(Node& node, const Place& place) {
  node.place = place;
  for (Key& key : node.keys) key.place = place;
  for (Node& item : node.items) set_place(item, place);
}

void add_scalars(const Node& node, std::vector<std::string>& names) {
  if (node.kind == NodeKind::scalar) names.push_back(node.text);
  for (const Node& item : node.items) add_scalars(item, names);
}

// Whatever stands under a key that names materials, in distributions too.
void add_material_names(const Node& node, std::vector<std::string>& names) {
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool is_name = node.kind == NodeKind::map &&
                         (node.keys[i].text == kMaterial || node.keys[i].text == kParts);
    if (is_name) {
      add_scalars(node.items[i], names);
    } else {
      add_material_names(node.items[i], names);
    }
  }
}

void lay_presets(Node& materials) {
  for (Node& material : materials.items) {
    const Node* preset = material.kind == NodeKind::map ? find(material, "preset") : nullptr;
    if (preset == nullptr || preset->kind != NodeKind::scalar) continue;
    const Node* known = find_known(preset->text);
    if (known == nullptr) continue;  // reported when the material is read
    Node lower = *known;
    // The reflection of a wall follows from its own keys.
    Node* coherent = find(lower, "coherent");
    if (coherent != nullptr && find(material, "wall") != nullptr) {
      *coherent = without(*coherent, "reflection");
    }
    set_place(lower, preset->place);
    material = merge_over(std::move(lower), without(material, "preset"));
  }
}

}  // namespace

std::string_view materials_yaml() { return material_files().front().text; }

std::vector<std::string> known_materials() {
  std::vector<std::string> names;
  for (const KnownMaterial& known : built_in()) names.push_back(known.name);
  return names;
}

void lay_known_materials(Node& root) {
  if (root.kind != NodeKind::map) return;
  const auto section = std::ranges::find(root.keys, kMaterials, &Key::text);
  const std::size_t at = static_cast<std::size_t>(section - root.keys.begin());
  if (section != root.keys.end()) {
    Node& materials = root.items[at];
    if (materials.kind != NodeKind::map) return;
    lay_presets(materials);
  }
  std::vector<std::string> names;
  add_material_names(root, names);
  Node used;
  used.kind = NodeKind::map;
  for (const std::string& name : names) {
    const Node* known = find_known(name);
    if (known == nullptr || find(used, name) != nullptr) continue;
    if (section != root.keys.end() && find(root.items[at], name) != nullptr) continue;
    used.keys.push_back({name, false, root.place});
    used.items.push_back(*known);
    set_place(used.items.back(), root.place);
  }
  if (used.keys.empty()) return;
  if (section == root.keys.end()) {
    root.keys.push_back({std::string(kMaterials), false, root.place});
    root.items.push_back(std::move(used));
    return;
  }
  Node& materials = root.items[at];
  materials.keys.insert(materials.keys.end(), used.keys.begin(), used.keys.end());
  materials.items.insert(materials.items.end(), used.items.begin(), used.items.end());
}

}  // namespace ensonify
