#include "core/navigation_tables.h"

#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {

bool has_table(const Navigation& navigation, NavigationTable table) {
  switch (table) {
    case NavigationTable::imu:
    case NavigationTable::imu_truth:
      return navigation.imu.has_value();
    case NavigationTable::dvl:
      return navigation.dvl.has_value();
    case NavigationTable::depth:
      return navigation.depth.has_value();
    case NavigationTable::altimeter:
      return navigation.altimeter.has_value();
    case NavigationTable::usbl:
      return navigation.usbl.has_value();
    case NavigationTable::gps:
      return navigation.gps.has_value();
    case NavigationTable::odometry:
      return navigation.odometry.has_value();
  }
  return false;
}

Pose mount_of(const std::optional<SensorMount>& mount) {
  if (!mount) return {};
  const auto& [x, y, z] = mount->position_m;
  const auto& [roll, pitch, yaw] = mount->rotation_deg;
  return {{x, y, z}, from_roll_pitch_yaw(radians(roll), radians(pitch), radians(yaw))};
}

std::array<Vec3, 4> dvl_beams(const Dvl& dvl) {
  const double across = std::sin(radians(dvl.beam_angle_deg)) * std::sqrt(0.5);
  const double down = -std::cos(radians(dvl.beam_angle_deg));
  return {{{across, across, down},
           {-across, across, down},
           {-across, -across, down},
           {across, -across, down}}};
}

DvlNormal inverse_normal(const std::array<Vec3, 4>& beams, const std::array<bool, 4>& locked) {
  DvlNormal normal{};
  int count = 0;
  for (std::size_t k = 0; k < beams.size(); ++k) {
    if (!locked[k]) continue;
    ++count;
    const Vec3& b = beams[k];
    normal[0] = normal[0] + b.x * b;
    normal[1] = normal[1] + b.y * b;
    normal[2] = normal[2] + b.z * b;
  }
  ENSONIFY_ASSERT(count >= 3);
  // The matrix is symmetric: its cofactors by rows are the columns of the adjugate as well.
  const double determinant = dot(normal[0], cross(normal[1], normal[2]));
  return {(1 / determinant) * cross(normal[1], normal[2]),
          (1 / determinant) * cross(normal[2], normal[0]),
          (1 / determinant) * cross(normal[0], normal[1])};
}

}  // namespace ensonify
