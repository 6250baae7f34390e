// The sonar and its beam model as sequence.json tells them.
#pragma once

#include "core/ping.h"
#include "dataset/json.h"

namespace ensonify {

// Every number of the instrument, in SI units and radians.
Json water_json(const Water& water);
Json sonar_json(const SequenceInfo& info);

// The beam model in words and formulas; every symbol is a number of sequence.json or a field of
// scatterers/*.npy.
Json model_json(const SequenceInfo& info);

// What one instance is and how it throws back.
Json instance_json(const Instance& instance);

}  // namespace ensonify
