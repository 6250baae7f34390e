// Warnings about likely mistakes in a scene.
//
//   scene_warnings  from its geometry alone
//   all_warnings    also from input files and from too few scatterers
//   likely_scale    of a mesh whose unit is not the meter
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/session.h"

namespace ensonify {

// Warns of a range at which absorption leaves no echo; of meshes whose file has no unit and that
// are longer than 30 m or shorter than 1 cm at scale 1; of a sonar inside a solid or below terrain
// at its first, middle or last ping; and of objects at the same place. Each warning is one line,
// without a line end.
std::vector<std::string> scene_warnings(const Session& session);

// All warnings about a scene, to be printed before it is made. `tracer` is that of the session's
// world.
std::vector<std::string> all_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers);

// The factor from millimeters, centimeters or inches to meters (or, for a mesh scaled down twice,
// the reverse) that makes the longest edge of a mesh 0.05 to 20 m; empty if there is none or the
// length is already likely.
std::optional<double> likely_scale(double longest_edge_m);

}  // namespace ensonify
