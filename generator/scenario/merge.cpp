#include "scenario/merge.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "scenario/draw.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

using Words = std::vector<std::string_view>;

// Groups of keys of which a map holds one alternative only.
const std::vector<std::vector<Words>>& exclusive_groups() {
  static const std::vector<std::vector<Words>> groups = {
      {{"spacing_deg"}, {"fov_deg"}},
      {{"rotation_deg"}, {"quaternion_wxyz"}},
      {{"fixed_db_m"}, {"model", "temperature_c", "salinity_psu", "ph", "depth_m"}},
      {{"poses"}, {"file"}},
      {{"depth_m", "sound_speed_m_s"}, {"file"}},
      {{"box"},
       {"sphere"},
       {"cylinder"},
       {"plane"},
       {"mesh"},
       {"heightfield"},
       {"model"},
       {"level_set"}},
      {{"size_m", "roughness", "ripples"}, {"file", "height_scale", "height_offset_m"}},
      {{"uniform"}, {"vdb"}, {"plume"}, {"school"}},
      {{"gaussian"}, {"flat"}, {"lfm"}, {"cw"}, {"table"}},
      {{"uniform"}, {"hann"}, {"taylor"}, {"chebyshev"}},
      {{"lambert"}, {"lommel_seeliger"}, {"table"}},
      {{"spectrum_level_db"}, {"snr_db"}},
      {{"uniform"}, {"log_uniform"}, {"normal"}, {"choice"}},
      {{"pose"}, {"place"}},
  };
  return groups;
}

bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// The keys that cannot stand beside `key`.
Words excluded_by(std::string_view key) {
  Words excluded;
  for (const auto& group : exclusive_groups()) {
    const bool concerns_key = std::any_of(group.begin(), group.end(),
                                          [&](const Words& words) { return contains(words, key); });
    if (!concerns_key) continue;
    for (const Words& words : group) {
      if (!contains(words, key)) excluded.insert(excluded.end(), words.begin(), words.end());
    }
  }
  return excluded;
}

void remove_keys(Node& map, const Words& unwanted) {
  for (std::size_t i = map.keys.size(); i-- > 0;) {
    if (!contains(unwanted, map.keys[i].text)) continue;
    map.keys.erase(map.keys.begin() + static_cast<std::ptrdiff_t>(i));
    map.items.erase(map.items.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

// Removes from a map what the value of `key`, unlike the key alone, excludes.
void remove_excluded_by_value(Node& map, std::string_view key) {
  const Node* value = find(map, key);
  if (value == nullptr) return;
  const bool table = value->text == "table" || find(*value, "table") != nullptr;
  if (key == "law" && table) remove_keys(map, {"reflectivity"});
  if (key == "model" && value->text == "rician")
    remove_keys(map, {"reflection", "roughness_rms_m"});
  if (key == "mode" && value->text == "beams") {
    remove_keys(map, {"elements", "spacing_m", "element_width_m", "shading", "focus", "steering",
                      "gain_error_db", "phase_error_deg", "dead"});
  }
  if (key == "model" && value->text == "kirchhoff") remove_keys(map, {"k"});
}

using Segments = std::vector<std::string_view>;

// Whether the keys of the map at this path are names of the user's, of which none excludes another.
bool holds_names(std::span<const std::string_view> path) {
  if (path.size() == 1) return path[0] == "materials";
  return path.size() == 5 && path[0] == "objects" && path[3] == "mesh" && path[4] == "parts";
}

// Whether at this path a word stands for a map of it: `flat` for {flat: {}}.
bool holds_kind(std::span<const std::string_view> path) {
  if (path.size() == 2) return path[0] == "sonar" && path[1] == "pulse";
  if (path.size() != 3) return false;
  const bool receives = path[0] == "sonar" && (path[1] == "beams" || path[1] == "receiver");
  return (receives && path[2] == "shading") || (path[0] == "materials" && path[2] == "law");
}

void expand_word(Node& node) {
  Node map;
  map.kind = NodeKind::map;
  map.place = node.place;
  Node options = map;
  map.keys.push_back({node.text, node.quoted, node.place});
  map.items.push_back(std::move(options));
  node = std::move(map);
}

Segments segments_of(std::string_view path) {
  Segments segments;
  for (;;) {
    const std::size_t dot = path.find('.');
    segments.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) return segments;
    path.remove_prefix(dot + 1);
  }
}

Node* item_of_name(Node& list, std::string_view name) {
  for (Node& item : list.items) {
    const Node* own = item.kind == NodeKind::map ? find(item, "name") : nullptr;
    if (own != nullptr && own->kind == NodeKind::scalar && own->text == name) return &item;
  }
  return nullptr;
}

// The item of a list that a segment names, made if it is the first behind the end.
Node* enter_list(Node& list, std::string_view segment, Place place, const std::string& path,
                 Faults& faults) {
  std::size_t index = 0;
  const char* last = segment.data() + segment.size();
  const auto [end, error] = std::from_chars(segment.data(), last, index);
  const std::size_t size = list.items.size();
  const bool is_index =
      error == std::errc{} && end == last && (segment.size() == 1 || segment[0] != '0');
  if (is_index && index <= size) {
    if (index == size) {
      list.items.emplace_back();
      list.items.back().place = place;
    }
    return &list.items[index];
  }
  if (Node* named = is_index ? nullptr : item_of_name(list, segment)) return named;
  add_fault(faults, place, path,
            fmt::format("{} names no item of a list of {}, accepted is an index from 0 to {}, or "
                        "the name of an item that has one",
                        shown(segment), size, size));
  return nullptr;
}

// The child of the node at `path` that a segment names, made if need be.
Node* enter(Node& node, std::span<const std::string_view> path, std::string_view segment,
            Place place, const std::string& whole_path, Faults& faults) {
  if (node.kind == NodeKind::list) return enter_list(node, segment, place, whole_path, faults);
  if (node.kind == NodeKind::scalar && holds_kind(path)) expand_word(node);
  if (node.kind == NodeKind::scalar) {
    add_fault(faults, place, whole_path,
              fmt::format("{} is a plain value and holds no {}, accepted is a path through maps "
                          "and lists",
                          shown(node.text), shown(segment)));
    return nullptr;
  }
  if (node.kind == NodeKind::null) {
    node.kind = NodeKind::map;
    node.place = place;
  }
  if (!holds_names(path)) remove_keys(node, excluded_by(segment));
  if (Node* found = find(node, segment)) return found;
  node.keys.push_back({std::string(segment), false, place});
  node.items.emplace_back();
  node.items.back().place = place;
  return &node.items.back();
}

}  // namespace

Node merge_over(Node lower, const Node& upper) {
  if (is_distribution(upper)) {
    Node merged = upper;
    if (upper.keys[0].text != "choice") return merged;
    for (Node& item : merged.items[0].items) item = merge_over(lower, item);
    return merged;
  }
  if (lower.kind != NodeKind::map || upper.kind != NodeKind::map) return upper;
  for (const Key& key : upper.keys) remove_keys(lower, excluded_by(key.text));
  for (std::size_t i = 0; i < upper.keys.size(); ++i) {
    const Key& key = upper.keys[i];
    if (Node* below = find(lower, key.text)) {
      *below = merge_over(std::move(*below), upper.items[i]);
      for (Key& own : lower.keys) {
        if (own.text == key.text) own.place = key.place;
      }
    } else {
      lower.keys.push_back(key);
      lower.items.push_back(upper.items[i]);
    }
  }
  lower.place = upper.place;
  return lower;
}

void apply_setting(Node& root, const Setting& setting, Faults& faults) {
  const auto& [path, place, value] = setting;
  const Segments segments = segments_of(path);
  for (const std::string_view segment : segments) {
    if (!segment.empty()) continue;
    add_fault(faults, place, path,
              "empty key in the path, accepted are keys, indexes and names joined by dots");
    return;
  }
  if (segments.size() > kMaxYamlDepth) {
    add_fault(faults, place, path, fmt::format("more than {} keys", kMaxYamlDepth));
    return;
  }
  std::vector<Node*> visited = {&root};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::span way(segments.data(), i);
    Node* node = enter(*visited.back(), way, segments[i], place, path, faults);
    if (node == nullptr) return;
    visited.push_back(node);
  }
  *visited.back() = value;
  // From the inside out: what is removed from a map moves what it holds.
  for (std::size_t i = segments.size(); i-- > 0;) {
    if (holds_names({segments.data(), i})) continue;
    remove_excluded_by_value(*visited[i], segments[i]);
  }
}

void apply_overrides(Node& root, const std::vector<Override>& overrides, Faults& faults) {
  for (const Override& override_ : overrides) {
    const int source = add_source(faults, "--set " + override_.path);
    auto value = read_yaml_value(override_.value, source, override_.path, faults);
    if (value) apply_setting(root, {override_.path, {source, 0, 0}, std::move(*value)}, faults);
  }
}

}  // namespace ensonify
