#include "world/parents.h"

#include <map>
#include <string>

namespace ensonify {

ParentTree parent_tree(const Scenario& scenario) {
  ParentTree tree;
  tree.parent.resize(scenario.objects.size());
  tree.children.resize(scenario.objects.size());
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    index.emplace(scenario.objects[i].name, i);
  }
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    if (scenario.objects[i].parent.empty()) continue;
    const std::size_t parent = index.at(scenario.objects[i].parent);
    tree.parent[i] = parent;
    tree.children[parent].push_back(i);
  }
  return tree;
}

std::vector<std::size_t> descendants(const ParentTree& tree, std::size_t object) {
  std::vector<std::size_t> found = tree.children[object];
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::vector<std::size_t>& next = tree.children[found[i]];
    found.insert(found.end(), next.begin(), next.end());
  }
  return found;
}

std::size_t root_of(const ParentTree& tree, std::size_t object) {
  while (tree.parent[object]) object = *tree.parent[object];
  return object;
}

void carry_children(const Scenario& scenario, const ParentTree& tree, std::size_t object,
                    World& world) {
  for (const std::size_t child : descendants(tree, object)) {
    const WorldObject& carrier = world.objects[*tree.parent[child]];
    const Pose pose = pose_of(scenario.objects[child].pose);
    WorldObject& carried = world.objects[child];
    carried.pose = compose(carrier.pose, pose);
    if (carrier.path == nullptr) continue;
    carried.path = std::make_shared<const Path>(Path{CarriedPath{carrier.path, pose}, {}});
  }
}

}  // namespace ensonify
