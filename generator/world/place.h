// Places objects at random: in an area on or above another object, or in a box of water. Placed
// objects keep clear of everything else.
//
//   place_objects   sets their poses
#pragma once

#include "core/error.h"
#include "core/random.h"
#include "scenario/scenario.h"
#include "world/parents.h"
#include "world/world.h"

namespace ensonify {

// Places the objects in the order of the scenario. Each place is keyed by seed, draw and name, and
// sampled again until the object and its descendants in `tree` have room. `world.objects` has every
// object of the scenario, with its shape. Objects without room whose place.on_failure is
// skip_object move from the world to `world.left_out`, with their descendants. Errors: no free
// place was found. They name the object and what to change, and on_failure determines their kind:
// redraw, usage or final_usage. Error (final_usage): a plane cannot be placed.
Status place_objects(const Scenario& scenario, SequenceDraw draw, const ParentTree& tree,
                     World& world);

}  // namespace ensonify
