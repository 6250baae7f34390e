// Sonar images of ROS 2, messages of marine_acoustic_msgs (Applied Physics Laboratory, University
// of Washington, https://github.com/apl-ocean-engineering/marine_msgs), in CDR. Private to
// recordings/.
//
//   Cursor           values one after another in bytes of ROS and of MCAP
//   RosImageKind     which message
//   parse_ros_image  one message
#pragma once

#include <cstdint>
#include <string_view>

#include "formats/bytes.h"
#include "recordings/log.h"

namespace ensonify {

// Values one after another. Once a value goes beyond the bytes, all are 0 and `whole` is false.
class Cursor {
 public:
  // CDR aligns numbers to their size; MCAP does not.
  Cursor(std::string_view bytes, bool aligned) : bytes_(bytes), aligned_(aligned) {}

  template <class T>
  T number() {
    if (aligned_) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    const std::string_view raw = take(sizeof(T));
    return whole_ ? value_at<T>(raw, 0) : T{};
  }
  std::string_view take(std::uint64_t count) {
    if (!whole_ || count > bytes_.size() - at_) {
      whole_ = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  // The bytes of an array of such numbers.
  template <class T>
  std::string_view array() {
    const std::uint64_t count = number<std::uint32_t>();
    if (aligned_ && count > 0) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    return take(count * sizeof(T));
  }
  bool whole() const { return whole_; }
  std::uint64_t at() const { return at_; }

 private:
  void skip(std::uint64_t count) { take(count); }

  std::string_view bytes_;
  std::uint64_t at_ = 0;
  bool aligned_, whole_ = true;
};

// ProjectedSonarImage: directions of beams and ranges. RawSonarImage: receive angles, positive to
// starboard, and the rate of samples. Both: counts [samples x beams], nearest first.
enum class RosImageKind { projected, raw };

// `message`: CDR with its header of four bytes; `offset`: its place in the log. Error (usage):
// another encoding or type of counts, sizes that do not fit, directions that do not rise or fall
// in azimuth, or ranges that are not equally spaced.
Result<LogFrame> parse_ros_image(const LogBytes& log, std::uint64_t offset, RosImageKind kind,
                                 std::string_view message, bool with_counts);

}  // namespace ensonify
