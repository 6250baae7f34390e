#include "export/ros_messages.h"

#include <span>
#include <string_view>

#include "formats/bytes.h"

namespace ensonify {
namespace {

constexpr std::uint64_t kNsOfSecond = 1'000'000'000;

// Plain CDR, little-endian. Each number is aligned to its size, relative to the end of the four
// header bytes.
class Cdr {
 public:
  template <class T>
  void number(T value) {
    while ((bytes_.size() - kHeaderBytes) % sizeof value != 0) bytes_ += '\0';
    put_value(bytes_, value);
  }
  void count(std::size_t items) { number(static_cast<std::uint32_t>(items)); }
  void text(std::string_view text) {
    count(text.size() + 1);
    bytes_.append(text).append(1, '\0');
  }
  void numbers(std::span<const float> values) {
    count(values.size());
    for (const float value : values) number(value);
  }
  void vector(const Vec3& v) {
    number(v.x);
    number(v.y);
    number(v.z);
  }
  void pose(const Pose& pose) {
    vector(pose.position_m);
    const Quat& q = pose.rotation;
    for (const double value : {q.x, q.y, q.z, q.w}) number(value);
  }
  void header(const RosHeader& header) {
    number(static_cast<std::int32_t>(header.time_ns / kNsOfSecond));
    number(static_cast<std::uint32_t>(header.time_ns % kNsOfSecond));
    text(header.frame_id);
  }
  void bytes(std::string_view values) {
    count(values.size());
    bytes_.append(values);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHeaderBytes = 4;
  std::string bytes_{"\0\1\0\0", kHeaderBytes};
};

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

}  // namespace ensonify
