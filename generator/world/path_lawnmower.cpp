#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "world/path_ways.h"

namespace ensonify {
namespace {

// A line and the half circle behind it.
double stride_m(const LawnmowerWay& way) { return way.length_m + kPi * way.spacing_m / 2; }

double lawnmower_length_m(const LawnmowerWay& way) {
  return way.lines * way.length_m + (way.lines - 1) * kPi * way.spacing_m / 2;
}

}  // namespace

LawnmowerWay make_way(const LawnmowerSpec& spec) {
  LawnmowerWay way;
  way.first_line = {{spec.corner_m[0], spec.corner_m[1], spec.corner_m[2]},
                    from_roll_pitch_yaw(0, 0, radians(spec.heading_deg))};
  way.length_m = spec.length_m;
  way.spacing_m = spec.spacing_m;
  // 3 m of width hold the fourth line 1 m apart whatever the last digit says.
  way.lines = std::floor(spec.width_m / spec.spacing_m * (1 + 1e-12)) + 1;
  way.speed_m_s = spec.speed_m_s;
  way.start_time_s = spec.start_time_s;
  return way;
}

TimeSpan span_of(const LawnmowerWay& way) {
  return {way.start_time_s, way.start_time_s + lawnmower_length_m(way) / way.speed_m_s};
}

Pose pose_on(const LawnmowerWay& way, double time_s) {
  const double gone_m =
      std::clamp((time_s - way.start_time_s) * way.speed_m_s, 0.0, lawnmower_length_m(way));
  const double line = std::min(std::floor(gone_m / stride_m(way)), way.lines - 1);
  const double along_m = gone_m - line * stride_m(way);
  const bool back = std::fmod(line, 2) != 0;
  const double radius_m = way.spacing_m / 2;
  const double turned = along_m > way.length_m ? (along_m - way.length_m) / radius_m : 0;
  const double x = std::min(along_m, way.length_m) + radius_m * std::sin(turned);
  const double y = line * way.spacing_m + radius_m * (1 - std::cos(turned));
  // Both half circles bend to port of the first line: the way back turns to starboard.
  const double yaw = back ? kPi - turned : turned;
  return compose(way.first_line,
                 {{back ? way.length_m - x : x, y, 0}, from_roll_pitch_yaw(0, 0, yaw)});
}

}  // namespace ensonify
