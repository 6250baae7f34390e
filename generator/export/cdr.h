// The encoding of ROS 2's messages. Private to export/.
//
//   RosHeader   time and frame of a message
//   Cdr         members one after another
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/vec.h"
#include "formats/bytes.h"

namespace ensonify {

struct RosHeader {
  std::uint64_t time_ns = 0;  // below 2^31 s
  std::string frame_id;
};

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
  void quaternion(const Quat& q) {
    for (const double value : {q.x, q.y, q.z, q.w}) number(value);
  }
  void pose(const Pose& pose) {
    vector(pose.position_m);
    quaternion(pose.rotation);
  }
  void header(const RosHeader& header) {
    number(static_cast<std::int32_t>(header.time_ns / kSecondNs));
    number(static_cast<std::uint32_t>(header.time_ns % kSecondNs));
    text(header.frame_id);
  }
  void bytes(std::string_view values) {
    count(values.size());
    bytes_.append(values);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::uint64_t kSecondNs = 1'000'000'000;
  static constexpr std::size_t kHeaderBytes = 4;
  std::string bytes_{"\0\1\0\0", kHeaderBytes};
};

}  // namespace ensonify
