// The way of a body through the world: poses in time.
//
//   Path       load_path pose_at
//   ping_times when the pings of a trajectory go out
#pragma once

#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/scenario.h"

namespace ensonify {

struct PathPoint {
  double time_s = 0;
  Pose pose;
};

// At least one point, in strictly increasing time.
struct Path {
  std::vector<PathPoint> points;
};

// From poses, from a TUM file (time x y z qx qy qz qw, blank-separated, # comments) or from a CSV
// file with a header that names time_s, x, y, z, qw, qx, qy, qz in any order (poses.csv of a data
// set is one; other columns are passed over, but they must hold numbers).
// Errors (usage): file:line and what is wrong there.
Result<Path> load_path(const TrajectorySpec& spec);

// Straight lines and spherical interpolation between the points; the ends hold.
Pose pose_at(const Path& path, double time_s);

// first point's time + k / rate, as many as asked for, or as the path's length holds (both ends
// included). Errors (usage): more pings than a path of several points lasts for.
Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path);

}  // namespace ensonify
