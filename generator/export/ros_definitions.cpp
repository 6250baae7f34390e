#include "export/ros_definitions.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "core/error.h"

namespace ensonify {
namespace {

struct Definition {
  std::string_view type, text;
};

constexpr Definition kDefinitions[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform",
     "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"sensor_msgs/Image",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
     "uint32 step\nuint8[] data\n"},
    {"sensor_msgs/PointField",
     "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
     "uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\n"
     "uint32 count\n"},
    {"sensor_msgs/PointCloud2",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
     "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
    {"vision_msgs/ObjectHypothesis", "string class_id\nfloat64 score\n"},
    {"vision_msgs/ObjectHypothesisWithPose",
     "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"},
    {"vision_msgs/Point2D", "float64 x\nfloat64 y\n"},
    {"vision_msgs/Pose2D", "vision_msgs/Point2D position\nfloat64 theta\n"},
    {"vision_msgs/BoundingBox2D", "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n"},
    {"vision_msgs/Detection2D",
     "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
     "vision_msgs/BoundingBox2D bbox\nstring id\n"},
    {"vision_msgs/Detection2DArray",
     "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n"},
    {"marine_acoustic_msgs/PingInfo",
     "float32 frequency\nfloat32 sound_speed\nfloat32[] tx_beamwidths\nfloat32[] rx_beamwidths\n"},
    {"marine_acoustic_msgs/SonarImageData",
     "bool is_bigendian\nuint32 DTYPE_UINT8=0\nuint32 DTYPE_INT8=1\nuint32 DTYPE_UINT16=2\n"
     "uint32 DTYPE_INT16=3\nuint32 DTYPE_UINT32=4\nuint32 DTYPE_INT32=5\nuint32 DTYPE_UINT64=6\n"
     "uint32 DTYPE_INT64=7\nuint32 DTYPE_FLOAT32=8\nuint32 DTYPE_FLOAT64=9\nuint32 dtype\n"
     "uint32 beam_count\nuint8[] data\n"},
    {"marine_acoustic_msgs/ProjectedSonarImage",
     "std_msgs/Header header\nmarine_acoustic_msgs/PingInfo ping_info\n"
     "geometry_msgs/Vector3[] beam_directions\nfloat32[] ranges\n"
     "marine_acoustic_msgs/SonarImageData image\n"},
    {"marine_interfaces/SonarInfo",
     "std_msgs/Header header\nstring sonar_model\nstring calibration_ref\n"
     "builtin_interfaces/Time calibration_time\nfloat32[] pulse_lengths\nfloat32[] bandwidths\n"
     "uint8 SIGNAL_TYPE_UNKNOWN=0\nuint8 SIGNAL_TYPE_CW=1\nuint8 SIGNAL_TYPE_FM_UP=2\n"
     "uint8 SIGNAL_TYPE_FM_DOWN=3\nuint8[] tx_signal_types\nuint8 QUANTITY_UNKNOWN=0\n"
     "uint8 QUANTITY_RAW_ADC=1\nuint8 QUANTITY_AMPLITUDE=2\nuint8 QUANTITY_POWER=3\n"
     "uint8 intensity_quantity\nuint8 INTENSITY_SCALE_UNKNOWN=0\nuint8 INTENSITY_SCALE_LINEAR=1\n"
     "uint8 INTENSITY_SCALE_DB=2\nuint8 intensity_scale\nuint8 REFERENCE_UNKNOWN=0\n"
     "uint8 REFERENCE_UNCALIBRATED_RELATIVE=1\nuint8 REFERENCE_ABSOLUTE_1UPA=2\n"
     "uint8 intensity_reference\nfloat32 scale\nfloat32 offset\nuint8 TVG_UNKNOWN=0\n"
     "uint8 TVG_NONE=1\nuint8 TVG_20LOGR=2\nuint8 TVG_40LOGR=3\nuint8 TVG_CUSTOM=4\n"
     "uint8 tvg_model\nfloat32 tvg_absorption_db_per_km\nfloat32 source_level_db\n"
     "uint8 ANGULAR_NORMALIZATION_UNKNOWN=0\nuint8 ANGULAR_NORMALIZATION_NOT_APPLIED=1\n"
     "uint8 ANGULAR_NORMALIZATION_APPLIED=2\nuint8 angular_normalization\n"
     "float32[] angular_response_angle_deg\nfloat32[] angular_response_db_rel_nadir\n"
     "uint8 ANGULAR_RESPONSE_TL_UNKNOWN=0\nuint8 ANGULAR_RESPONSE_TL_IN=1\n"
     "uint8 ANGULAR_RESPONSE_TL_REMOVED=2\nuint8 angular_response_tl\n"
     "float32 angular_response_absorption_db_per_m\nfloat32[] beam_pattern_angle_deg\n"
     "float32[] beam_pattern_gain_db\n"},
};

std::string_view text_of(std::string_view type) {
  const auto found = std::find_if(std::begin(kDefinitions), std::end(kDefinitions),
                                  [&](const Definition& one) { return one.type == type; });
  ENSONIFY_ASSERT(found != std::end(kDefinitions));
  return found->text;
}

// Appends the types of the fields that are messages, each once, and what these contain.
void add_parts(std::string_view text, std::vector<std::string_view>& parts) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(line.size() + 1);
    const std::string_view type = line.substr(0, line.find_first_of(" ["));
    if (type.find('/') == std::string_view::npos) continue;
    if (std::find(parts.begin(), parts.end(), type) != parts.end()) continue;
    parts.push_back(type);
    add_parts(text_of(type), parts);
  }
}

}  // namespace

std::string ros_definition(std::string_view type) {
  const std::size_t package = type.find("/msg/");
  ENSONIFY_ASSERT(package != std::string_view::npos);
  const std::string name =
      std::string(type.substr(0, package)) + std::string(type.substr(package + 4));
  std::vector<std::string_view> parts;
  add_parts(text_of(name), parts);
  std::string definition(text_of(name));
  for (const std::string_view part : parts) {
    definition.append(80, '=').append("\nMSG: ").append(part).append("\n").append(text_of(part));
  }
  return definition;
}

}  // namespace ensonify
