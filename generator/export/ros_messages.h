// Messages of ROS 2: their bytes in CDR, little-endian, and their definitions in the form of
// `ros2msg`. Private to export/. Members have the names of the messages where these have no unit.
//
//   ProjectedSonarImage   marine_acoustic_msgs
//   SonarInfo             marine_interfaces
//   PoseStamped           geometry_msgs
//   TfMessage             tf2_msgs
//   RosImage  PointCloud2 sensor_msgs
//   Detections            vision_msgs/Detection2DArray
//   encode                a message's bytes; `kName` is its type
//   ros_definition        of a message and of all that it contains
//
// Sources: std_msgs, geometry_msgs, sensor_msgs, builtin_interfaces (ros2/common_interfaces),
// tf2_msgs, vision_msgs (branch ros2), marine_acoustic_msgs (apl-ocean-engineering/marine_msgs) and
// marine_interfaces (rolker/unh_marine_autonomy, commit b4bbc7d, which proposes SonarInfo for
// marine_acoustic_msgs).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "export/cdr.h"

namespace ensonify {

struct ProjectedSonarImage {
  static constexpr char kName[] = "marine_acoustic_msgs/msg/ProjectedSonarImage";
  enum Type : std::uint32_t { kUint8 = 0, kFloat32 = 8 };

  RosHeader header;
  float frequency_hz = 0, sound_speed_m_s = 0;
  std::vector<float> tx_beamwidths_rad, rx_beamwidths_rad;
  std::vector<Vec3> beam_directions;  // the message's frame: z ahead, x up, y to starboard
  std::vector<float> ranges_m;
  std::uint32_t beam_count = 0;
  Type type = kUint8;
  std::string data;  // values of that type; beams of the nearest range first
};

struct SonarInfo {
  static constexpr char kName[] = "marine_interfaces/msg/SonarInfo";
  enum Signal : std::uint8_t { kSignalUnknown, kCw, kFmUp };
  enum Quantity : std::uint8_t { kQuantityUnknown, kRawAdc, kAmplitude };
  enum Scale : std::uint8_t { kScaleUnknown, kLinear, kDb };
  enum Reference : std::uint8_t { kReferenceUnknown, kRelative, kAbsolute };
  enum Tvg : std::uint8_t { kTvgUnknown, kNoTvg, k20LogR, k40LogR, kCustomTvg };
  enum Normalization : std::uint8_t { kNormalizationUnknown, kNotNormalized };

  RosHeader header;
  std::string sonar_model;
  std::vector<float> pulse_lengths_s, bandwidths_hz;
  std::vector<std::uint8_t> signal_types;
  Quantity quantity = kQuantityUnknown;
  Scale scale = kScaleUnknown;
  Reference reference = kReferenceUnknown;
  float raw_scale = 0, raw_offset = 0;  // physical = raw scale + offset; scale 0: no such map
  Tvg tvg = kTvgUnknown;
  float tvg_absorption_db_km = std::numeric_limits<float>::quiet_NaN();
  float source_level_db = std::numeric_limits<float>::quiet_NaN();
  Normalization angular_normalization = kNormalizationUnknown;
};

struct PoseStamped {
  static constexpr char kName[] = "geometry_msgs/msg/PoseStamped";

  RosHeader header;
  Pose pose;
};

struct TfMessage {
  static constexpr char kName[] = "tf2_msgs/msg/TFMessage";
  struct Transform {
    RosHeader header;  // of the parent
    std::string child_frame_id;
    Pose child_in_parent;
  };

  std::vector<Transform> transforms;
};

struct RosImage {
  static constexpr char kName[] = "sensor_msgs/msg/Image";

  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;  // mono8, 8UC1 or 16UC1
  std::uint32_t step = 0;
  std::string data;
};

struct PointCloud2 {
  static constexpr char kName[] = "sensor_msgs/msg/PointCloud2";
  // Each field has one value: x, y, z, intensity (float32), instance (uint16), class (uint8).
  static constexpr std::uint32_t kPointBytes = 20;

  RosHeader header;
  std::string data;

  // Appends a point.
  void add(const Vec3& place, float intensity, std::uint16_t instance, std::uint8_t class_id);
};

struct Detections {
  static constexpr char kName[] = "vision_msgs/msg/Detection2DArray";
  struct Detection {
    std::string class_name, id;
    std::array<double, 4> box{};  // left, top, width, height
    std::optional<Pose> pose;     // in the frame of the header; absent: NaN
  };

  RosHeader header;
  std::vector<Detection> detections;
};

std::string encode(const ProjectedSonarImage& message);
std::string encode(const SonarInfo& message);
std::string encode(const PoseStamped& message);
std::string encode(const TfMessage& message);
std::string encode(const RosImage& message);
std::string encode(const PointCloud2& message);
std::string encode(const Detections& message);

// `type` is PACKAGE/msg/NAME of a message that is defined here.
std::string ros_definition(std::string_view type);

}  // namespace ensonify
