// Objects whose poses are in the frames of other objects, with which they move.
//
//   ParentTree  parent_tree   the parent of each object
//   descendants  root_of      children, grandchildren and so on; the end of a chain of parents
//   carry_children            the poses of children in the world
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// Indices are those of scenario.objects.
struct ParentTree {
  std::vector<std::optional<std::size_t>> parent;
  std::vector<std::vector<std::size_t>> children;
};

ParentTree parent_tree(const Scenario& scenario);

// Parents come before their children.
std::vector<std::size_t> descendants(const ParentTree& tree, std::size_t object);
std::size_t root_of(const ParentTree& tree, std::size_t object);

// Sets the poses and paths of an object's descendants. `world` has every object of the scenario.
void carry_children(const Scenario& scenario, const ParentTree& tree, std::size_t object,
                    World& world);

}  // namespace ensonify
