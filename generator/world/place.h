// Objects that a scenario leaves to be placed: somewhere in an area, standing on another object,
// clear of everything else.
//
//   place_objects   sets their poses
#pragma once

#include <cstdint>

#include "core/error.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// In the order of the scenario, each drawn again until it stands free, keyed by seed, sequence and
// name. `world.objects` has every object of the scenario, with its shape.
// Errors (usage): no free place found, with the object's name and what to change.
Status place_objects(const Scenario& scenario, std::uint32_t sequence, World& world);

}  // namespace ensonify
