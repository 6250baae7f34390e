// Warnings about likely mistakes in a scene.
//
//   is_empty_scene  nothing in any sequence can echo
//   scene_warnings  from its geometry alone
//   all_warnings    also from input files and from gaps between rays
//   gap_warnings    from gaps between rays
//   likely_scale    of a mesh whose unit is not the meter
//   check_mount     an error: an instrument of a rig inside the body that carries it
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "ping/session.h"

namespace ensonify {

bool is_empty_scene(const Session& session);

// An empty scene; a range from which absorption leaves no echo; meshes without a unit of their own
// that are longer than 100 m or shorter than 1 cm at scale 1; a sonar inside a solid or below
// terrain at its first, middle or last ping; objects at the same place; spheres whose echoes miss
// more than 1 % of their energy; key_warnings. One line each, without line ends.
std::vector<std::string> scene_warnings(const Session& session);

// All warnings about a scene, to be printed before it is made. `tracer` is that of the session's
// world.
std::vector<std::string> all_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers);

// Warnings if over more than a twentieth of the range that the rays of the first ping cover, they
// are so far apart that pixels hear none of them. Multipath echoes, which adaptive refinement and
// scatterers fixed on surfaces do not affect, are judged by the rays of the fan. `tracer` is that
// of the session's world.
std::vector<std::string> gap_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers);

// Error (usage) if a sonar or camera of a rig is inside a solid that moves with it, or rests as it
// does, at the first, middle and last ping. Without a rig this is a warning.
Status check_mount(const Session& session);

// The factor from millimeters to meters (or, for a mesh scaled down twice, the reverse) that makes
// the longest edge of a mesh 0.05 to 100 m; empty if there is none or the length is already likely,
// from 1 cm to 100 m.
std::optional<double> likely_scale(double longest_edge_m);

}  // namespace ensonify
