// Messages of ROS 2 from navigation sensors, as in ros_messages.h. Private to export/.
//
//   ImuMessage  FluidPressure  RangeMessage  NavSatFix   sensor_msgs
//   DvlMessage                                           marine_acoustic_msgs
//   PoseFix                                              geometry_msgs/PoseWithCovarianceStamped
//   OdometryMessage                                      nav_msgs
//   kBodyFrame  body_in_world  sensor_frames              frames of the sensors
//   encode                                               a message's bytes; `kName` is its type
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/navigation.h"
#include "core/vec.h"
#include "export/ros_messages.h"

namespace ensonify {

inline constexpr char kBodyFrame[] = "base_link";

Pose body_in_world(const NavigationInfo& navigation, const Pose& sonar_in_world);

// The sonar and each sensor on the body, with frames as the messages want them: that of the DVL has
// z along its axis and x forward, that of the altimeter x along the beam.
std::vector<TfMessage::Transform> sensor_frames(const NavigationInfo& navigation,
                                                const RosHeader& body, const char* sonar_frame);

// Row-major.
using Covariance3 = std::array<double, 9>;

// Without an orientation.
struct ImuMessage {
  static constexpr char kName[] = "sensor_msgs/msg/Imu";

  RosHeader header;
  Vec3 angular_velocity_rad_s, acceleration_m_s2;          // the specific force
  double angular_variance = 0, acceleration_variance = 0;  // of each axis; 0: unknown
};

struct DvlMessage {
  static constexpr char kName[] = "marine_acoustic_msgs/msg/Dvl";

  RosHeader header;  // a frame with z along the axis, x forward
  Vec3 velocity_m_s;
  Covariance3 velocity_covariance{};
  double altitude_m = 0;
  std::uint8_t good_beams = 0;
  float sound_speed_m_s = 0;
  std::array<Vec3, 4> beams;
  std::array<double, 4> range_m{}, velocity_of_beam_m_s{};
  std::array<double, 4> range_variance{};
  double velocity_variance = 0;  // of each beam
};

struct FluidPressure {
  static constexpr char kName[] = "sensor_msgs/msg/FluidPressure";

  RosHeader header;
  double pressure_pa = 0, variance = 0;
};

// Along x of its frame.
struct RangeMessage {
  static constexpr char kName[] = "sensor_msgs/msg/Range";

  RosHeader header;
  float range_min_m = 0, range_max_m = 0;
  float range_m = 0;  // infinite: no echo
  float variance = 0;
};

struct NavSatFix {
  static constexpr char kName[] = "sensor_msgs/msg/NavSatFix";

  RosHeader header;
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  double horizontal_variance = 0, vertical_variance = 0;
};

// A position; the orientation is unknown.
struct PoseFix {
  static constexpr char kName[] = "geometry_msgs/msg/PoseWithCovarianceStamped";

  RosHeader header;
  Vec3 position_m;
  Covariance3 covariance{};
};

// Without covariances.
struct OdometryMessage {
  static constexpr char kName[] = "nav_msgs/msg/Odometry";

  RosHeader header;
  std::string child_frame_id;
  Pose pose;
  Vec3 velocity_m_s, angular_rate_rad_s;  // in the child's frame
};

std::string encode(const ImuMessage& message);
std::string encode(const DvlMessage& message);
std::string encode(const FluidPressure& message);
std::string encode(const RangeMessage& message);
std::string encode(const NavSatFix& message);
std::string encode(const PoseFix& message);
std::string encode(const OdometryMessage& message);

}  // namespace ensonify
