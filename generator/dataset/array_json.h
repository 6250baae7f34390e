// The element-level array as sequence.json tells it.
#pragma once

#include "core/ping.h"
#include "dataset/json.h"

namespace ensonify {

// sonar.receiver, every number of each element. Needs sonar.array.
Json receiver_json(const SequenceInfo& info);

// In place of the beam model's members of `model`: the array's series, its symbols, the pattern of
// an element and the sum of the weights.
void set_array_model(const SequenceInfo& info, Json& model);

}  // namespace ensonify
