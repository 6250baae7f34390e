#include "export/ros_messages.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "formats/bytes.h"

namespace ensonify {
namespace {

void put_detection(Cdr& cdr, const RosHeader& header, const Detections::Detection& detection) {
  cdr.header(header);
  cdr.count(1);  // results
  cdr.text(detection.class_name);
  cdr.number(1.0);  // score
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  constexpr Pose kNoPose{{kUnknown, kUnknown, kUnknown}, {kUnknown, kUnknown, kUnknown, kUnknown}};
  cdr.pose(detection.pose.value_or(kNoPose));
  for (int i = 0; i < 36; ++i) cdr.number(0.0);  // covariance
  const auto [left, top, width, height] = detection.box;
  for (const double value : {left + width / 2, top + height / 2, 0.0, width, height}) {
    cdr.number(value);
  }
  cdr.text(detection.id);
}

}  // namespace

std::string encode(const ProjectedSonarImage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(message.frequency_hz);
  cdr.number(message.sound_speed_m_s);
  cdr.numbers(message.tx_beamwidths_rad);
  cdr.numbers(message.rx_beamwidths_rad);
  cdr.count(message.beam_directions.size());
  for (const Vec3& direction : message.beam_directions) cdr.vector(direction);
  cdr.numbers(message.ranges_m);
  cdr.number(std::uint8_t{0});  // is_bigendian
  cdr.number(static_cast<std::uint32_t>(message.type));
  cdr.number(message.beam_count);
  cdr.bytes(message.data);
  return cdr.bytes();
}

std::string encode(const SonarInfo& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.text(message.sonar_model);
  cdr.text("");                  // calibration_ref
  cdr.number(std::int32_t{0});   // calibration_time
  cdr.number(std::uint32_t{0});  // ... its nanoseconds
  cdr.numbers(message.pulse_lengths_s);
  cdr.numbers(message.bandwidths_hz);
  cdr.count(message.signal_types.size());
  for (const std::uint8_t type : message.signal_types) cdr.number(type);
  for (const std::uint8_t axis : {std::uint8_t{message.quantity}, std::uint8_t{message.scale},
                                  std::uint8_t{message.reference}}) {
    cdr.number(axis);
  }
  cdr.number(message.raw_scale);
  cdr.number(message.raw_offset);
  cdr.number(std::uint8_t{message.tvg});
  cdr.number(message.tvg_absorption_db_km);
  cdr.number(message.source_level_db);
  cdr.number(std::uint8_t{message.angular_normalization});
  cdr.numbers({});              // angular response
  cdr.numbers({});              // ... its levels
  cdr.number(std::uint8_t{0});  // ... with which transmission loss: unknown
  cdr.number(std::numeric_limits<float>::quiet_NaN());
  cdr.numbers({});  // beam pattern
  cdr.numbers({});  // ... its gains
  return cdr.bytes();
}

std::string encode(const PoseStamped& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.pose(message.pose);
  return cdr.bytes();
}

std::string encode(const TfMessage& message) {
  Cdr cdr;
  cdr.count(message.transforms.size());
  for (const TfMessage::Transform& transform : message.transforms) {
    cdr.header(transform.header);
    cdr.text(transform.child_frame_id);
    cdr.pose(transform.child_in_parent);
  }
  return cdr.bytes();
}

std::string encode(const RosImage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(message.height);
  cdr.number(message.width);
  cdr.text(message.encoding);
  cdr.number(std::uint8_t{0});  // is_bigendian
  cdr.number(message.step);
  cdr.bytes(message.data);
  return cdr.bytes();
}

void PointCloud2::add(const Vec3& place, float intensity, std::uint16_t instance,
                      std::uint8_t class_id) {
  for (const double value : {place.x, place.y, place.z}) {
    put_value(data, static_cast<float>(value));
  }
  put_value(data, intensity);
  put_value(data, instance);
  put_value(data, class_id);
  put_value(data, std::uint8_t{0});  // up to the size of a point
}

std::string encode(const PointCloud2& message) {
  constexpr std::uint8_t kUint8 = 2, kUint16 = 4, kFloat32 = 7;
  struct Field {
    const char* name;
    std::uint32_t offset;
    std::uint8_t type;
  };
  constexpr Field kFields[] = {{"x", 0, kFloat32},        {"y", 4, kFloat32},
                               {"z", 8, kFloat32},        {"intensity", 12, kFloat32},
                               {"instance", 16, kUint16}, {"class", 18, kUint8}};
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(std::uint32_t{1});  // height
  cdr.count(message.data.size() / PointCloud2::kPointBytes);
  cdr.count(std::size(kFields));
  for (const Field& field : kFields) {
    cdr.text(field.name);
    cdr.number(field.offset);
    cdr.number(field.type);
    cdr.number(std::uint32_t{1});
  }
  cdr.number(std::uint8_t{0});  // is_bigendian
  cdr.number(PointCloud2::kPointBytes);
  cdr.count(message.data.size());  // row_step
  cdr.bytes(message.data);
  cdr.number(std::uint8_t{1});  // is_dense
  return cdr.bytes();
}

std::string encode(const Detections& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.count(message.detections.size());
  for (const Detections::Detection& detection : message.detections) {
    put_detection(cdr, message.header, detection);
  }
  return cdr.bytes();
}

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
    {"geometry_msgs/PoseWithCovarianceStamped",
     "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
     "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
     "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
     "float64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/FluidPressure",
     "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n"},
    {"sensor_msgs/Range",
     "std_msgs/Header header\nuint8 ULTRASOUND=0\nuint8 INFRARED=1\nuint8 radiation_type\n"
     "float32 field_of_view\nfloat32 min_range\nfloat32 max_range\nfloat32 range\n"
     "float32 variance\n"},
    {"sensor_msgs/NavSatStatus",
     "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\n"
     "int8 status\nuint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\n"
     "uint16 SERVICE_GALILEO=8\nuint16 service\n"},
    {"sensor_msgs/NavSatFix",
     "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\n"
     "float64 longitude\nfloat64 altitude\nfloat64[9] position_covariance\n"
     "uint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n"
     "uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\n"
     "uint8 position_covariance_type\n"},
    {"marine_acoustic_msgs/Dvl",
     "uint8 DVL_MODE_BOTTOM=1\nuint8 DVL_MODE_WATER=2\nuint8 DVL_TYPE_PISTON=0\n"
     "uint8 DVL_TYPE_PHASED_ARRAY=1\nstd_msgs/Header header\nuint8 velocity_mode\n"
     "uint8 dvl_type\ngeometry_msgs/Vector3 velocity\nfloat64[9] velocity_covar\n"
     "float64 altitude\nfloat64 course_gnd\nfloat64 speed_gnd\nuint8 num_good_beams\n"
     "float32 sound_speed\nbool beam_ranges_valid\nbool beam_velocities_valid\n"
     "geometry_msgs/Vector3[4] beam_unit_vec\nfloat64[4] range\nfloat32[4] range_covar\n"
     "float32[4] beam_quality\nfloat32[4] beam_velocity\nfloat32[4] beam_velocity_covar\n"},
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
