// Messages of ROS 2 in CDR, little-endian, and their definitions in the form of `ros2msg`. Private
// to export/.
//
//   ProjectedSonarImage   marine_acoustic_msgs
//   PoseStamped           geometry_msgs
//   encode                a message's bytes
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/vec.h"

namespace ensonify {

struct RosHeader {
  std::uint64_t time_ns = 0;  // below 2^31 s
  std::string frame_id;
};

struct ProjectedSonarImage {
  static constexpr char kName[] = "marine_acoustic_msgs/msg/ProjectedSonarImage";
  static const char* const kDefinition;

  RosHeader header;
  float frequency_hz = 0, sound_speed_m_s = 0;
  std::vector<float> tx_beamwidths_rad, rx_beamwidths_rad;
  std::vector<Vec3> beam_directions;  // the message's frame: z ahead, x up, y to starboard
  std::vector<float> ranges_m;
  std::uint32_t beam_count = 0;
  std::vector<std::uint8_t> data;  // of 8 bits; beams of the nearest range first
};

struct PoseStamped {
  static constexpr char kName[] = "geometry_msgs/msg/PoseStamped";
  static const char* const kDefinition;

  RosHeader header;
  Pose pose;
};

std::string encode(const ProjectedSonarImage& message);
std::string encode(const PoseStamped& message);

}  // namespace ensonify
