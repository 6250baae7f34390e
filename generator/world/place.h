// Objects that a scenario leaves to be placed: somewhere in an area, standing on another object,
// clear of everything else.
//
//   place_objects   sets their poses
#pragma once

#include "core/error.h"
#include "core/random.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// In the order of the scenario, each drawn again until it stands free, keyed by seed, draw and name.
// `world.objects` has every object of the scenario, with its shape. Objects whose place.on_failure
// is skip_object and for which there is no room go from the world into `world.left_out`.
// Errors: no free place found, with the object's name and what to change; their kind is redraw,
// usage or final_usage as on_failure says. Error (final_usage): a plane cannot be placed.
Status place_objects(const Scenario& scenario, SequenceDraw draw, World& world);

}  // namespace ensonify
