// Parents of entries with counts: each copy moves with the copy of the parent that has the same
// number.
#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "scenario/draw.h"
#include "scenario/reader.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

Node* parent_in(Node& object) {
  Node* pose = object.kind == NodeKind::map ? find(object, "pose") : nullptr;
  Node* parent = pose != nullptr && pose->kind == NodeKind::map ? find(*pose, "parent") : nullptr;
  return parent != nullptr && parent->kind == NodeKind::scalar ? parent : nullptr;
}

std::string mismatch(const Copies* own, const Copies& parents) {
  const std::string one = fmt::format("the name of one of them, as {}_0", parents.name);
  if (own == nullptr) {
    return fmt::format("{} stands for {} objects; expected {}", shown(parents.name), parents.count,
                       one);
  }
  return fmt::format(
      "{} stands for {} objects and its parent {} for {}; expected equal counts, for example from "
      "one variable, or {}",
      shown(own->name), own->count, shown(parents.name), parents.count, one);
}

}  // namespace

void name_parents(Node& objects, const std::vector<Copies>& copies, Faults& faults) {
  std::unordered_map<std::string, const Copies*> by_name;
  for (const Copies& made : copies) by_name.emplace(made.name, &made);
  std::unordered_set<std::string> names;
  for (const Node& object : objects.items) {
    const Node* name = object.kind == NodeKind::map ? find(object, "name") : nullptr;
    if (name != nullptr) names.insert(name->text);
  }
  auto next = copies.begin();
  for (std::size_t i = 0; i < objects.items.size(); ++i) {
    while (next != copies.end() && i >= next->first + static_cast<std::size_t>(next->count)) ++next;
    const Copies* own = next != copies.end() && i >= next->first ? &*next : nullptr;
    Node* parent = parent_in(objects.items[i]);
    if (parent == nullptr || names.contains(parent->text)) continue;
    const auto found = by_name.find(parent->text);
    if (found == by_name.end()) continue;
    if (own != nullptr && own->count == found->second->count) {
      parent->text = fmt::format("{}_{}", parent->text, i - own->first);
      continue;
    }
    add_fault(faults, parent->place, fmt::format("objects.{}.pose.parent", i),
              mismatch(own, *found->second));
    return;
  }
}

}  // namespace ensonify
