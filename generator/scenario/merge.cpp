#include "scenario/merge.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

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
      {{"box"}, {"sphere"}, {"cylinder"}, {"plane"}, {"mesh"}},
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

std::vector<std::string_view> segments_of(std::string_view path) {
  std::vector<std::string_view> segments;
  for (;;) {
    const std::size_t dot = path.find('.');
    segments.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) return segments;
    path.remove_prefix(dot + 1);
  }
}

// The item of a list that a segment names, made if it is the first behind the end.
Node* enter_list(Node& list, std::string_view segment, Place place, const std::string& path,
                 Faults& faults) {
  std::size_t index = 0;
  const char* last = segment.data() + segment.size();
  const auto [end, error] = std::from_chars(segment.data(), last, index);
  const std::size_t size = list.items.size();
  if (error != std::errc{} || end != last || (segment.size() > 1 && segment[0] == '0') ||
      index > size) {
    add_fault(faults, place, path,
              fmt::format("{} names no item of a list of {}, accepted is an index from 0 to {}",
                          shown(segment), size, size));
    return nullptr;
  }
  if (index == size) {
    list.items.emplace_back();
    list.items.back().place = place;
  }
  return &list.items[index];
}

// `free_names`: the keys of this map are names of the user's, none excludes another.
Node* enter(Node& node, std::string_view segment, bool free_names, Place place,
            const std::string& path, Faults& faults) {
  if (node.kind == NodeKind::list) return enter_list(node, segment, place, path, faults);
  if (node.kind == NodeKind::scalar) {
    add_fault(faults, place, path,
              fmt::format("{} is a plain value and holds no {}, accepted is a path through maps "
                          "and lists",
                          shown(node.text), shown(segment)));
    return nullptr;
  }
  if (node.kind == NodeKind::null) {
    node.kind = NodeKind::map;
    node.place = place;
  }
  if (!free_names) remove_keys(node, excluded_by(segment));
  if (Node* found = find(node, segment)) return found;
  node.keys.push_back({std::string(segment), false, place});
  node.items.emplace_back();
  node.items.back().place = place;
  return &node.items.back();
}

void apply_override(Node& root, const Override& override_, Faults& faults) {
  const int source = add_source(faults, "--set " + override_.path);
  const Place place{source, 0, 0};
  const std::vector<std::string_view> segments = segments_of(override_.path);
  for (const std::string_view segment : segments) {
    if (!segment.empty()) continue;
    add_fault(faults, place, override_.path,
              "empty key in the path, accepted are keys and indexes joined by dots");
    return;
  }
  if (segments.size() > kMaxYamlDepth) {
    add_fault(faults, place, override_.path, fmt::format("more than {} keys", kMaxYamlDepth));
    return;
  }
  std::optional<Node> value = read_yaml_value(override_.value, source, override_.path, faults);
  if (!value) return;
  Node* node = &root;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool free_names = i == 1 && segments[0] == "materials";
    node = enter(*node, segments[i], free_names, place, override_.path, faults);
    if (node == nullptr) return;
  }
  *node = std::move(*value);
}

}  // namespace

Node merge_over(Node lower, const Node& upper) {
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

void apply_overrides(Node& root, const std::vector<Override>& overrides, Faults& faults) {
  for (const Override& override_ : overrides) apply_override(root, override_, faults);
}

}  // namespace ensonify
