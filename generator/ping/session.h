// A scenario prepared to run: all input has been checked, and nothing has been written.
//
//   PingRange  Session
//   sonar_pose  object_poses   at a ping
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/ping.h"
#include "scenario/scenario.h"
#include "trace/adaptive.h"
#include "trace/mirrors.h"
#include "trace/surface_points.h"
#include "world/path.h"
#include "world/world.h"

namespace ensonify {

using PingRange = std::pair<std::uint32_t, std::uint32_t>;  // [first, last)

struct Session {
  Scenario scenario;
  Sonar sonar;
  Water water;
  Record record;
  ResolutionCell cell;  // only from prepare_session
  Pose mount;           // sonar on the body
  World world;
  BouncePlan bounces;                              // without paths if there is no multipath
  Path path;                                       // of the body
  std::vector<double> ping_times_s;                // of all pings, whatever range is run
  std::optional<SurfaceTiles> surface_tiles = {};  // with speckle: surface
  std::optional<Placement> placement = {};         // only from drawn_session
};

inline Pose sonar_pose(const Session& session, std::uint32_t ping) {
  return compose(pose_at(session.path, session.ping_times_s[ping]), session.mount);
}

// Of each of World::objects.
inline std::vector<Pose> object_poses(const Session& session, std::uint32_t ping) {
  std::vector<Pose> poses;
  for (const WorldObject& object : session.world.objects) {
    poses.push_back(object_pose(object, session.ping_times_s[ping]));
  }
  return poses;
}

}  // namespace ensonify
