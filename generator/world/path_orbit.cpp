#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "world/path_ways.h"

namespace ensonify {

OrbitWay make_way(const OrbitSpec& spec) {
  OrbitWay way;
  way.center_m = {spec.center_m[0], spec.center_m[1], spec.center_m[2]};
  way.radius_m = spec.radius_m;
  way.speed_m_s = spec.speed_m_s;
  way.start_rad = radians(spec.start_deg);
  way.swept_rad = 2 * kPi * spec.turns;
  way.look = spec.look;
  way.start_time_s = spec.start_time_s;
  return way;
}

TimeSpan span_of(const OrbitWay& way) {
  return {way.start_time_s,
          way.start_time_s + std::abs(way.swept_rad) * way.radius_m / way.speed_m_s};
}

Pose pose_on(const OrbitWay& way, double time_s) {
  const double gone_rad = std::clamp((time_s - way.start_time_s) * way.speed_m_s / way.radius_m,
                                     0.0, std::abs(way.swept_rad));
  const double bearing = way.start_rad + std::copysign(gone_rad, way.swept_rad);
  double yaw = bearing;
  if (way.look == OrbitLook::inward) yaw += kPi;
  if (way.look == OrbitLook::along) yaw += std::copysign(kPi / 2, way.swept_rad);
  return {way.center_m + way.radius_m * Vec3{std::cos(bearing), std::sin(bearing), 0},
          from_roll_pitch_yaw(0, 0, yaw)};
}

}  // namespace ensonify
