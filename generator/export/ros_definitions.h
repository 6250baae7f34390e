// Definitions of ROS 2 messages in the form of `ros2msg`. Private to export/.
//
//   ros_definition   of a message and of all that it contains
//
// Sources: std_msgs, geometry_msgs, sensor_msgs, builtin_interfaces (ros2/common_interfaces),
// tf2_msgs, vision_msgs (branch ros2), marine_acoustic_msgs (apl-ocean-engineering/marine_msgs) and
// marine_interfaces (rolker/unh_marine_autonomy, commit b4bbc7d, which proposes SonarInfo for
// marine_acoustic_msgs).
#pragma once

#include <string>
#include <string_view>

namespace ensonify {

// `type` is PACKAGE/msg/NAME of a message that is defined here.
std::string ros_definition(std::string_view type);

}  // namespace ensonify
