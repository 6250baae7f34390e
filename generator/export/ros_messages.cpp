#include "export/ros_messages.h"

#include <string_view>

#include "formats/bytes.h"

namespace ensonify {

const char* const ProjectedSonarImage::kDefinition = R"(std_msgs/Header header
marine_acoustic_msgs/PingInfo ping_info
geometry_msgs/Vector3[] beam_directions
float32[] ranges
marine_acoustic_msgs/SonarImageData image
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: marine_acoustic_msgs/PingInfo
float32 frequency
float32 sound_speed
float32[] tx_beamwidths
float32[] rx_beamwidths
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: marine_acoustic_msgs/SonarImageData
bool is_bigendian
uint32 DTYPE_UINT8=0
uint32 DTYPE_INT8=1
uint32 DTYPE_UINT16=2
uint32 DTYPE_INT16=3
uint32 DTYPE_UINT32=4
uint32 DTYPE_INT32=5
uint32 DTYPE_UINT64=6
uint32 DTYPE_INT64=7
uint32 DTYPE_FLOAT32=8
uint32 DTYPE_FLOAT64=9
uint32 dtype
uint32 beam_count
uint8[] data
)";

const char* const PoseStamped::kDefinition = R"(std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
)";

namespace {

constexpr std::uint64_t kSecondNs = 1'000'000'000;

// Plain CDR, little-endian. Each number is aligned to its size, relative to the end of the four
// header bytes.
class Cdr {
 public:
  template <class T>
  void number(T value) {
    while ((bytes_.size() - kHeaderBytes) % sizeof value != 0) bytes_ += '\0';
    put_value(bytes_, value);
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text).append(1, '\0');
  }
  void numbers(std::span<const float> values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const float value : values) number(value);
  }
  void vector(const Vec3& v) {
    number(v.x);
    number(v.y);
    number(v.z);
  }
  void header(const RosHeader& header) {
    number(static_cast<std::int32_t>(header.time_ns / kSecondNs));
    number(static_cast<std::uint32_t>(header.time_ns % kSecondNs));
    text(header.frame_id);
  }
  void append(std::span<const std::uint8_t> values) {
    number(static_cast<std::uint32_t>(values.size()));
    bytes_.append(static_cast<const char*>(static_cast<const void*>(values.data())), values.size());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHeaderBytes = 4;
  std::string bytes_{"\0\1\0\0", kHeaderBytes};
};

}  // namespace

std::string encode(const ProjectedSonarImage& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.number(message.frequency_hz);
  cdr.number(message.sound_speed_m_s);
  cdr.numbers(message.tx_beamwidths_rad);
  cdr.numbers(message.rx_beamwidths_rad);
  cdr.number(static_cast<std::uint32_t>(message.beam_directions.size()));
  for (const Vec3& direction : message.beam_directions) cdr.vector(direction);
  cdr.numbers(message.ranges_m);
  cdr.number(std::uint8_t{0});   // is_bigendian
  cdr.number(std::uint32_t{0});  // DTYPE_UINT8
  cdr.number(message.beam_count);
  cdr.append(message.data);
  return cdr.bytes();
}

std::string encode(const PoseStamped& message) {
  Cdr cdr;
  cdr.header(message.header);
  cdr.vector(message.pose.position_m);
  const Quat& q = message.pose.rotation;
  for (const double value : {q.x, q.y, q.z, q.w}) cdr.number(value);
  return cdr.bytes();
}

}  // namespace ensonify
