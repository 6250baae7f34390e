#include <fmt/format.h>

#include "scenario/scenario.h"
#include "scenario/scenario_tree.h"
#include "scenario/yaml_tree.h"

namespace ensonify {
namespace {

// The item of a list or the value of a key.
const Node* step(const Node& node, const std::string& name) {
  if (node.kind == NodeKind::map) return find(node, name);
  if (node.kind != NodeKind::list || name.empty() || name.size() > 9 ||
      name.find_first_not_of("0123456789") != std::string::npos) {
    return nullptr;
  }
  const std::size_t at = std::stoul(name);
  return at < node.items.size() ? &node.items[at] : nullptr;
}

}  // namespace

std::optional<Place> place_in(const Node& tree, std::string_view path) {
  const Node* deepest = &tree;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const Node* next = step(*deepest, std::string(path.substr(begin, end - begin)));
    if (next == nullptr) break;
    deepest = next;
    begin = end + 1;
  }
  return deepest == &tree ? std::nullopt : std::optional(deepest->place);
}

Error with_place(const Error& error, const std::string& text, const std::string& label,
                 const std::vector<Override>& overrides) {
  const std::string path = error.message.substr(0, error.message.find(": "));
  for (const Override& given : overrides) {
    if (path.starts_with(given.path) || given.path.starts_with(path)) return error;
  }
  Faults faults;
  const std::optional<Node> tree = read_yaml_map(text, add_source(faults, label), faults);
  const auto place = tree ? place_in(*tree, path) : std::nullopt;
  if (!place) return error;
  return {error.kind,
          fmt::format("{}:{}:{}: {}", label, place->line, place->column, error.message)};
}

}  // namespace ensonify
