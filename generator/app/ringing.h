// Point targets that are elastic spheres: their echoes for one sonar.
//
//   ring_targets
#pragma once

#include "core/sonar.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// Gives the targets of the world that are spheres in the scenario, whose targets are in the same
// order, their taps over the sonar's band, and their instances the sphere and its target strength
// at the carrier. Equal spheres are computed once.
void ring_targets(const Scenario& scenario, const Sonar& sonar, const Water& water, World& world);

}  // namespace ensonify
