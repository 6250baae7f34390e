// The coefficients with which beams are sums of nodes, by least squares over the array.
#pragma once

#include <vector>

#include "synthesis/cpu/array_nodes.h"

namespace ensonify {

// Stretches from the last sample down to where nodes stop to pay: nodes.spacing_u must be set; sets
// stretches, orders and near_samples.
void choose_stretches(const ArrayPlan& plan, ArrayNodes& nodes);

}  // namespace ensonify
