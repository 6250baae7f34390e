// The poses of objects that a scenario does not give in the world: those in the frames of other
// objects, with which they move, and those that are placed at random, in an area on or above
// another object or in a box of water. Placed objects keep clear of everything else.
//
//   ParentTree  parent_tree   the parent of each object
//   descendants  root_of      children, grandchildren and so on; the end of a chain of parents
//   carry_children            the poses of children in the world
//   place_objects             the poses of placed objects
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "world/world.h"

namespace ensonify {

struct Scenario;

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

// Places the objects in the order of the scenario. Each place is keyed by seed, draw and name, and
// sampled again until the object and its descendants in `tree` have room. `world.objects` has every
// object of the scenario, with its shape. Objects without room whose place.on_failure is
// skip_object move from the world to `world.left_out`, with their descendants. Errors: no free
// place was found. They name the object and what to change, and on_failure determines their kind:
// redraw, incomplete (the sequence cannot be made) or final_usage. Error (usage): a plane cannot be
// placed.
Status place_objects(const Scenario& scenario, SequenceDraw draw, const ParentTree& tree,
                     World& world);

}  // namespace ensonify
