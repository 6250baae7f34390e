// A scenario prepared to run: all input has been checked, and nothing has been written.
//
//   PingRange  Session
//   sonar_pose  object_poses   at a ping, or at a time
//   distinct_pings             a few that show what pings can differ in
//   most_surface_points        with speckle: surface
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/ping.h"
#include "scenario/rig.h"
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
  BouncePlan bounces;                // without paths if there is no multipath
  Path path;                         // of the body
  std::vector<double> ping_times_s;  // of all pings, whatever range is run
  // With speckle: surface; those of all sonars of a rig.
  std::shared_ptr<const SurfaceTiles> surface_tiles = {};
  std::optional<Placement> placement = {};  // only from drawn_session
};

inline Pose sonar_pose_at(const Session& session, double time_s) {
  return compose(pose_at(session.path, time_s), session.mount);
}
inline Pose sonar_pose(const Session& session, std::uint32_t ping) {
  return sonar_pose_at(session, session.ping_times_s[ping]);
}

// Of each of World::objects.
inline std::vector<Pose> object_poses_at(const Session& session, double time_s) {
  std::vector<Pose> poses;
  for (const WorldObject& object : session.world.objects) {
    poses.push_back(object_pose(object, time_s));
  }
  return poses;
}
inline std::vector<Pose> object_poses(const Session& session, std::uint32_t ping) {
  return object_poses_at(session, session.ping_times_s[ping]);
}

// The first, the middle and the last ping, without those at which the sonar and all objects are
// where they were at one of the others.
inline std::vector<std::uint32_t> distinct_pings(const Session& session) {
  const auto last = static_cast<std::uint32_t>(session.ping_times_s.size() - 1);
  std::vector<std::uint32_t> pings;
  for (const std::uint32_t ping : {0u, last / 2, last}) {
    const bool is_known = std::ranges::any_of(pings, [&](std::uint32_t known) {
      return sonar_pose(session, known) == sonar_pose(session, ping) &&
             object_poses(session, known) == object_poses(session, ping);
    });
    if (!is_known) pings.push_back(ping);
  }
  return pings;
}

// The approximate maximum in the fan of a ping. Needs surface_tiles.
inline std::uint64_t most_surface_points(const Session& session) {
  if (!is_sonar(session.scenario)) return 0;
  const auto& rig = session.scenario.rig;
  const auto chosen = static_cast<std::ptrdiff_t>(chosen_index(session.scenario).value_or(0));
  const auto sonars =
      std::count_if(rig.begin(), rig.begin() + std::min(chosen, std::ssize(rig)),
                    [](const InstrumentSpec& before) { return before.sonar.has_value(); });
  return session.surface_tiles->most_leaves[static_cast<std::size_t>(sonars)];
}

}  // namespace ensonify
