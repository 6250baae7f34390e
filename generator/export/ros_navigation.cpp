#include "export/ros_navigation.h"

#include <cmath>

#include "core/navigation_tables.h"
#include "core/units.h"
#include "export/cdr.h"

namespace ensonify {
namespace {

void put_diagonal(Cdr& cdr, double x, double y, double z) {
  for (const double value : {x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z}) cdr.number(value);
}

void put_zeros(Cdr& cdr, int count) {
  for (int i = 0; i < count; ++i) cdr.number(0.0);
}

// Half a turn about x: y to starboard, z down.
constexpr Quat kDown{0, 1, 0, 0};

Pose turned(const Pose& pose, const Quat& rotation) {
  return {pose.position_m, pose.rotation * rotation};
}

// Variance of an unknown angle, rad^2.
constexpr double kUnknownAngle = 1e9;

}  // namespace

Pose body_in_world(const NavigationInfo& navigation, const Pose& sonar_in_world) {
  const Pose& mount = navigation.sonar_in_body;
  const Quat rotation = sonar_in_world.rotation * conjugate(mount.rotation);
  return {sonar_in_world.position_m - rotate(rotation, mount.position_m), rotation};
}

std::vector<TfMessage::Transform> sensor_frames(const NavigationInfo& navigation,
                                                const RosHeader& body, const char* sonar_frame) {
  std::vector<TfMessage::Transform> frames = {{body, sonar_frame, navigation.sonar_in_body}};
  const auto add = [&](const auto& sensor, const char* frame, const Quat& rotation) {
    if (sensor) frames.push_back({body, frame, turned(mount_of(sensor->mount), rotation)});
  };
  const auto& [imu, dvl, depth, altimeter, usbl, gps, odometry] = navigation.sensors;
  add(imu, "imu_link", {});
  add(dvl, "dvl_link", kDown);
  add(depth, "depth_link", {});
  add(altimeter, "altimeter_link", from_roll_pitch_yaw(0, kPi / 2, 0));
  add(usbl, "usbl_link", {});
  add(gps, "gps_link", {});
  return frames;
}

std::string encode(const ImuMessage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.quaternion({});
  put_diagonal(cdr, -1, 0, 0);  // there is no orientation
  cdr.vector(message.angular_velocity_rad_s);
  const double turning = message.angular_variance, force = message.acceleration_variance;
  put_diagonal(cdr, turning, turning, turning);
  cdr.vector(message.acceleration_m_s2);
  put_diagonal(cdr, force, force, force);
  return cdr.bytes();
}

std::string encode(const DvlMessage& message) {
  constexpr std::uint8_t kBottom = 1, kPiston = 0;
  const Vec3& v = message.velocity_m_s;
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(kBottom);
  cdr.number(kPiston);
  cdr.vector(v);
  for (const double value : message.velocity_covariance) cdr.number(value);
  cdr.number(message.altitude_m);
  cdr.number(std::atan2(v.y, v.x));
  cdr.number(std::hypot(v.x, v.y));
  cdr.number(message.good_beams);
  cdr.number(message.sound_speed_m_s);
  cdr.number(std::uint8_t{1});  // beam_ranges_valid
  cdr.number(std::uint8_t{1});  // beam_velocities_valid
  for (const Vec3& beam : message.beams) cdr.vector(beam);
  for (const double range : message.range_m) cdr.number(range);
  for (const double variance : message.range_variance) cdr.number(static_cast<float>(variance));
  for (const double range : message.range_m) cdr.number(std::isnan(range) ? 0.0F : 1.0F);
  for (const double velocity : message.velocity_of_beam_m_s) {
    cdr.number(static_cast<float>(velocity));
  }
  for (int k = 0; k < 4; ++k) cdr.number(static_cast<float>(message.velocity_variance));
  return cdr.bytes();
}

std::string encode(const FluidPressure& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(message.pressure_pa);
  cdr.number(message.variance);
  return cdr.bytes();
}

std::string encode(const RangeMessage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(std::uint8_t{0});  // ultrasound
  cdr.number(0.0F);             // field of view: one ray
  cdr.number(message.range_min_m);
  cdr.number(message.range_max_m);
  cdr.number(message.range_m);
  cdr.number(message.variance);
  return cdr.bytes();
}

std::string encode(const NavSatFix& message) {
  constexpr std::uint8_t kDiagonalKnown = 2;
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(std::int8_t{0});    // a fix
  cdr.number(std::uint16_t{1});  // GPS
  cdr.number(message.latitude_deg);
  cdr.number(message.longitude_deg);
  cdr.number(message.altitude_m);
  put_diagonal(cdr, message.horizontal_variance, message.horizontal_variance,
               message.vertical_variance);
  cdr.number(kDiagonalKnown);
  return cdr.bytes();
}

std::string encode(const PoseFix& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.pose({message.position_m, {}});
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column < 6; ++column) {
      if (row < 3 && column < 3) {
        cdr.number(message.covariance[3 * row + column]);
      } else {
        cdr.number(row == column ? kUnknownAngle : 0.0);
      }
    }
  }
  return cdr.bytes();
}

std::string encode(const OdometryMessage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.text(message.child_frame_id);
  cdr.pose(message.pose);
  put_zeros(cdr, 36);
  cdr.vector(message.velocity_m_s);
  cdr.vector(message.angular_rate_rad_s);
  put_zeros(cdr, 36);
  return cdr.bytes();
}

}  // namespace ensonify
