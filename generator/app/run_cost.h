// What a run of a sweep will take, from its scenario alone: no world is built and nothing traced,
// so that thousands are estimated in a second. Sums of whole numbers: the same on every machine.
#pragma once

#include "sweep/expand.h"

namespace ensonify {

// Errors (usage): those of prepare_without_world.
Result<RunCost> run_cost(Scenario scenario);

}  // namespace ensonify
