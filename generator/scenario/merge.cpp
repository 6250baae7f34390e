#include "scenario/merge.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "scenario/distribution.h"
#include "scenario/key_facts.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

using Words = std::vector<std::string_view>;

// The keys that exclude `key`; distributions exclude each other.
Words excluded_beside(std::string_view key) {
  Words excluded = excluded_by(key);
  constexpr std::array<std::string_view, 4> kDistributions = {"uniform", "log_uniform", "normal",
                                                              "choice"};
  if (std::find(kDistributions.begin(), kDistributions.end(), key) == kDistributions.end()) {
    return excluded;
  }
  for (const std::string_view other : kDistributions) {
    if (other != key) excluded.push_back(other);
  }
  return excluded;
}

void remove_keys(Node& map, const Words& unwanted) {
  for (std::size_t i = map.keys.size(); i-- > 0;) {
    if (std::find(unwanted.begin(), unwanted.end(), map.keys[i].text) == unwanted.end()) continue;
    map.keys.erase(map.keys.begin() + static_cast<std::ptrdiff_t>(i));
    map.items.erase(map.items.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

// Removes from a map the keys that the value of `key` excludes, unlike the key itself.
void remove_excluded_by_value(Node& map, std::string_view key) {
  const Node* value = find(map, key);
  if (value == nullptr) return;
  remove_keys(map, excluded_by_value(key, *value));
}

using Segments = std::vector<std::string_view>;

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

// The name that an item of a list has, if it has one.
const Node* own_name(const Node& item) {
  const Node* name = item.kind == NodeKind::map ? find(item, "name") : nullptr;
  return name != nullptr && name->kind == NodeKind::scalar ? name : nullptr;
}

Words names_of_items(const Node& list) {
  Words names;
  for (const Node& item : list.items) {
    if (const Node* name = own_name(item)) names.push_back(name->text);
  }
  return names;
}

Node* item_of_name(Node& list, std::string_view name) {
  for (Node& item : list.items) {
    const Node* own = own_name(item);
    if (own != nullptr && own->text == name) return &item;
  }
  return nullptr;
}

// The item of a list that a segment names; the item after the last one is appended.
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
  const Words names = names_of_items(list);
  add_fault(faults, place, path,
            fmt::format("{} names no item of this list of length {}{}; expected an index from 0 to "
                        "{}{}",
                        shown(segment), size, hint(segment, names), size,
                        names.empty() ? "" : " or one of " + joined(names)));
  return nullptr;
}

// The child of the node at `path` that a segment names; a missing one is added.
Node* enter(Node& node, std::span<const std::string_view> path, std::string_view segment,
            Place place, const std::string& whole_path, Faults& faults) {
  if (node.kind == NodeKind::list) return enter_list(node, segment, place, whole_path, faults);
  if (node.kind == NodeKind::scalar && holds_kind(path)) expand_word(node);
  if (node.kind == NodeKind::scalar) {
    add_fault(
        faults, place, whole_path,
        fmt::format(
            "{} is a plain value and cannot contain {}; expected a path through maps and lists",
            shown(node.text), shown(segment)));
    return nullptr;
  }
  if (node.kind == NodeKind::null) {
    node.kind = NodeKind::map;
    node.place = place;
  }
  if (!holds_names(path)) remove_keys(node, excluded_beside(segment));
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
  for (const Key& key : upper.keys) remove_keys(lower, excluded_beside(key.text));
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
              "the path has an empty key; expected keys, indexes and names joined by dots");
    return;
  }
  if (segments.size() > kMaxYamlDepth) {
    add_fault(faults, place, path, fmt::format("the path has more than {} keys", kMaxYamlDepth));
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
  // From the inside out, because removing a key moves the values after it.
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
