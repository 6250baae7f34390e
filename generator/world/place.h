// Places objects at random: in an area, standing on another object or above it, or in a box of
// water, clear of everything else.
//
//   place_objects   sets their poses
#pragma once

#include "core/error.h"
#include "core/random.h"
#include "scenario/scenario.h"
#include "world/parents.h"
#include "world/world.h"

namespace ensonify {

// In the order of the scenario, each sampled again until it and its descendants in `tree` stand
// free, keyed by seed, draw and name. `world.objects` has every object of the scenario, with its
// shape. Objects without room whose place.on_failure is skip_object move from the world to
// `world.left_out`, with their descendants. Errors: no free place found, with the object's name and
// what to change; their kind is redraw, usage or final_usage as on_failure says. Error
// (final_usage): a plane cannot be placed.
Status place_objects(const Scenario& scenario, SequenceDraw draw, const ParentTree& tree,
                     World& world);

}  // namespace ensonify
