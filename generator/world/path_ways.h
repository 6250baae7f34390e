// The ways of a body without its jitter: samples, and curves known at every instant.
//
//   SampledWay  LawnmowerWay  OrbitWay  SplineWay
//   pose_on     where the body is; before the start and after the end it rests there
//   span_of     from when to when
#pragma once

#include <array>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/path_spec.h"

namespace ensonify {

struct PathPoint {
  double time_s = 0;
  Pose pose;
};

// At least one point, in strictly increasing time. Straight lines and spherical interpolation.
struct SampledWay {
  std::vector<PathPoint> points;
};

// Line k starts at k spacings to port; half circles of half a spacing join the lines, so that
// heading and speed never jump.
struct LawnmowerWay {
  Pose first_line;  // where it begins; x along it
  double length_m = 0;
  double spacing_m = 0;
  double lines = 1;
  double speed_m_s = 0;
  double start_time_s = 0;
};

struct OrbitWay {
  Vec3 center_m;
  double radius_m = 0;
  double speed_m_s = 0;
  double start_rad = 0, swept_rad = 0;  // swept below zero: clockwise
  OrbitLook look = OrbitLook::inward;
  double start_time_s = 0;
};

// One cubic a + u (b + u (c + u d)), u from 0 to 1, with its arc length at kParts + 1 even steps.
struct SplineSegment {
  static constexpr int kParts = 32;
  Vec3 a, b, c, d;
  std::array<double, kParts + 1> arc_m{};  // from the start of the whole spline
};

// Centripetal Catmull-Rom through all points, first and last one continued straight.
struct SplineWay {
  std::vector<SplineSegment> segments;
  double speed_m_s = 0;
  std::optional<Vec3> look_at_m;
  double start_time_s = 0;
};

LawnmowerWay make_way(const LawnmowerSpec& spec);
OrbitWay make_way(const OrbitSpec& spec);
SplineWay make_way(const SplineSpec& spec);
SampledWay make_way(const std::vector<TimedPoseSpec>& poses);

// From a TUM file (time x y z qx qy qz qw, blank-separated, # comments) or a CSV file with a
// header that names time_s, x, y, z, qw, qx, qy, qz in any order (poses.csv of a data set is one;
// other columns are passed over, but they must hold numbers).
// Errors (usage): file:line and what is wrong there.
Result<SampledWay> load_path_file(const std::filesystem::path& file);

Pose pose_on(const SampledWay& way, double time_s);
Pose pose_on(const LawnmowerWay& way, double time_s);
Pose pose_on(const OrbitWay& way, double time_s);
Pose pose_on(const SplineWay& way, double time_s);

struct TimeSpan {
  double start_s = 0, end_s = 0;
};
TimeSpan span_of(const SampledWay& way);
TimeSpan span_of(const LawnmowerWay& way);
TimeSpan span_of(const OrbitWay& way);
TimeSpan span_of(const SplineWay& way);

}  // namespace ensonify
