// Paths of a body for the tests of its navigation sensors, and rows that they emit.
#pragma once

#include <vector>

#include "navigation/course.h"

namespace ensonify {

using SensorRows = std::vector<std::vector<double>>;

inline EmitRow collect(SensorRows& rows) {
  return [&rows](std::span<const double> row) { rows.emplace_back(row.begin(), row.end()); };
}

inline Course course_on(const Path& path, double from_s, double to_s, std::uint64_t key = 1) {
  return {[path](double time_s) { return pose_at(path, time_s); },
          span_of(path),
          from_s,
          from_s,
          to_s,
          key};
}

inline Path path_of(TrajectorySpec spec) { return *load_path(spec, 7); }

inline Path at_rest(PoseSpec pose = {}) {
  TrajectorySpec spec;
  spec.path = std::vector<TimedPoseSpec>{{0, pose}};
  return path_of(spec);
}

inline Vec3 vec_at(const std::vector<double>& row, std::size_t i) {
  return {row[i], row[i + 1], row[i + 2]};
}

}  // namespace ensonify
