// Sonar images of ROS 2, messages of marine_acoustic_msgs (Applied Physics Laboratory, University
// of Washington, https://github.com/apl-ocean-engineering/marine_msgs), in CDR. Private to
// recordings/.
//
//   Cursor           values one after another in bytes of ROS and of MCAP
//   RosImageKind     which message
//   RosScale  parse_sonar_info   what another message says of the values
//   parse_ros_image  one message
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
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

// What SonarInfo says of the values of an image: dB or linear, of amplitude or of power, and the
// line physical = scale raw + offset; scale 0: it does not say.
struct RosScale {
  enum class Kind { unknown, linear, db } kind = Kind::unknown;
  bool power = false;
  double scale = 0, offset = 0;
};

// SonarInfo of marine_interfaces or marine_acoustic_msgs. Error (usage): another encoding, a
// message that is shorter than its members, or a map that is not of numbers.
Result<RosScale> parse_sonar_info(const LogBytes& log, std::uint64_t offset,
                                  std::string_view message);

// What the values of a topic mean, as --db and SonarInfo say.
struct RosValues {
  std::string topic;
  std::optional<std::array<double, 2>> db;  // of counts, as in LogChoices
  std::optional<RosScale> info;
};

// `message`: CDR with its header of four bytes; `offset`: its place in the log. Levels in floats
// become counts of 16 bits between -100 and 227.675 dB, whose step is 0.005 dB. Error (usage):
// another encoding or type of counts, sizes that do not fit, directions that do not rise or fall
// in azimuth, ranges that are not equally spaced; floats that no SonarInfo describes; a SonarInfo
// that contradicts --db, or that says dB without limits.
Result<LogFrame> parse_ros_image(const LogBytes& log, std::uint64_t offset, RosImageKind kind,
                                 std::string_view message, const RosValues& values,
                                 bool with_counts);

}  // namespace ensonify
