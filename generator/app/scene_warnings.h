// What is likely to be a mistake in a scene.
//
//   scene_warnings  from its geometry alone
//   all_warnings    of input files and of too few scatterers as well
//   likely_scale    of a mesh whose unit is not the metre
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/session.h"

namespace ensonify {

// A range from which absorption lets nothing come back, meshes without a unit of their own that are over 30 m or under 1 cm long at scale 1, a sonar
// within something solid or below terrain at its first, middle or last ping, and objects that lie in
// one another's place. One line each, without line ends.
std::vector<std::string> scene_warnings(const Session& session);

// What the user is told of a scene before it is made. `tracer` is of the session's world.
std::vector<std::string> all_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers);

// The factor from millimetres, centimetres or inches (or, of a mesh scaled down twice, into them)
// that makes the longest edge of a mesh one of 0.05 to 20 m; nothing where none does or where it is
// of a likely length already.
std::optional<double> likely_scale(double longest_edge_m);

}  // namespace ensonify
