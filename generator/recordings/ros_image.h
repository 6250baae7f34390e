// Sonar images of ROS 2, messages of marine_acoustic_msgs (Applied Physics Laboratory, University
// of Washington, https://github.com/apl-ocean-engineering/marine_msgs), in CDR. Private to
// recordings/.
//
//   RosImageKind     which message
//   parse_ros_image  one message
#pragma once

#include <cstdint>
#include <string_view>

#include "recordings/log.h"

namespace ensonify {

// ProjectedSonarImage: directions of beams and ranges. RawSonarImage: receive angles, positive to
// starboard, and the rate of samples. Both: counts [samples x beams], nearest first.
enum class RosImageKind { projected, raw };

// `message`: CDR with its header of four bytes; `offset`: its place in the log. Error (usage):
// another encoding or type of counts, sizes that do not fit, directions that do not rise or fall
// in azimuth, or ranges that are not equally spaced.
Result<LogFrame> parse_ros_image(const LogBytes& log, std::uint64_t offset, RosImageKind kind,
                                 std::string_view message, bool with_counts);

}  // namespace ensonify
