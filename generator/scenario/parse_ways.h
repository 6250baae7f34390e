// The ways that a formula gives, and the jitter on any way. Private to scenario/.
#pragma once

#include "scenario/path_spec.h"
#include "scenario/reader.h"

namespace ensonify {

// Recorded stamps count from 1970.
inline constexpr NumberRange kPathTime = from_to(-1e12, 1e12);

void parse_lawnmower(Faults& faults, const Value& map, LawnmowerSpec& way);
void parse_orbit(Faults& faults, const Value& map, OrbitSpec& way);
void parse_spline(Faults& faults, const Value& map, SplineSpec& way);
void parse_jitter(Faults& faults, const Value& map, JitterSpec& jitter);

}  // namespace ensonify
