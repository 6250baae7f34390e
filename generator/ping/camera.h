// The camera of a session: what its scenario's keys become, and what is checked before it runs.
//
//   camera_of      of a session, with the mounts of camera and sonar
//   camera_pose    at a ping
//   camera_colors  of the surfaces
//   check_camera   whether it stays below the water surface
#pragma once

#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/error.h"
#include "ping/session.h"

namespace ensonify {

// None without the key `camera`.
std::optional<Camera> camera_of(const Scenario& scenario);

// The camera's frame in the world. Needs a camera.
Pose camera_pose(const Session& session, const Camera& camera, std::uint32_t ping);

// By instance id, 0 included, and by Hit::part: the colors of the object's own material, of other
// materials of its parts, and of what has grown.
std::vector<std::vector<Rgb>> camera_colors(const Scenario& scenario,
                                            const std::vector<Instance>& instances);

// Error (usage): at some ping the camera is not below the water surface.
Status check_camera(const Session& session);

}  // namespace ensonify
