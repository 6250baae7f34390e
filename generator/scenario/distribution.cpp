// What in a tree is drawn, and how many alternatives it has.
#include <algorithm>

#include "scenario/draw.h"

namespace ensonify {

bool is_head_key(std::string_view key) {
  return key == "ensonify" || key == "seed" || key == "sequences";
}

bool is_distribution(const Node& node) {
  if (node.kind != NodeKind::map || node.keys.size() != 1) return false;
  if (node.items[0].kind != NodeKind::list) return false;
  const std::string& key = node.keys[0].text;
  return key == "uniform" || key == "log_uniform" || key == "normal" || key == "choice";
}

bool holds_distribution(const Node& node) {
  return is_distribution(node) ||
         std::any_of(node.items.begin(), node.items.end(), holds_distribution);
}

bool has_counts(std::string_view section, const Node& node) {
  return is_counted_list(section) && node.kind == NodeKind::list &&
         std::any_of(node.items.begin(), node.items.end(), [](const Node& entry) {
           return entry.kind == NodeKind::map && find(entry, "count") != nullptr;
         });
}

bool is_counted_list(std::string_view path) { return path == "objects" || path == "point_targets"; }

std::size_t variants_of_choice(const Node& alternatives) {
  std::size_t sum = 0;
  for (const Node& alternative : alternatives.items) sum += draw_variants(alternative);
  return std::max<std::size_t>(sum, 1);
}

std::size_t draw_variants(const Node& node) {
  if (is_distribution(node) && node.keys[0].text == "choice") {
    return variants_of_choice(node.items[0]);
  }
  std::size_t most = 1;
  for (const Node& item : node.items) most = std::max(most, draw_variants(item));
  return most;
}

}  // namespace ensonify
