// Elastic bodies: their echoes for one sonar.
//
//   ring_bodies
#pragma once

#include "core/sonar.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// Gives the objects and point targets of the world that are elastic in the scenario, which has them
// in the same order, their taps over the sonar's band and their instances the body; targets also
// get the target strength at the carrier. Equal bodies are computed once.
void ring_bodies(const Scenario& scenario, const Sonar& sonar, const Water& water, World& world);

}  // namespace ensonify
