// Whether a scene has scatterers enough for speckle.
#pragma once

#include <string>
#include <vector>

#include "app/session.h"
#include "core/parallel.h"
#include "trace/tracer.h"

namespace ensonify {

// Fewer of them in a resolution cell do not make developed speckle.
inline constexpr double kFewScatterers = 10;

// What to tell the user where more than a twentieth of the range that the rays of the first ping
// pass over has fewer than kFewScatterers a cell; bounced echoes, which no rays by need reach and
// no scatterers fixed on surfaces make, are judged by the rays of the fan. `tracer` is of the
// session's world.
std::vector<std::string> starved_warnings(const Session& session, const Tracer& tracer,
                                          const Workers& workers);

}  // namespace ensonify
