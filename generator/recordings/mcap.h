// ROS 2 recordings in MCAP with messages marine_acoustic_msgs/msg/ProjectedSonarImage: polar images
// with the direction of each beam and the range of each row, [ranges x beams], nearest first.
//
// Layout: https://mcap.dev/spec, and the message definitions of marine_msgs (Applied Physics
// Laboratory, University of Washington). The file is read from its start to its end; its index is
// not used.
//
//   is_mcap           by the first four bytes
//   read_mcap         message by message
//   parse_projected   one message
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "recordings/log.h"

namespace ensonify {

bool is_mcap(std::string_view bytes);

// `message`: CDR with its header of four bytes; `offset`: its place in the log. Error (usage):
// another encoding or type of counts, sizes that do not fit, directions that do not rise or fall
// in azimuth, or ranges that are not equally spaced.
Result<LogFrame> parse_projected(const LogBytes& log, std::uint64_t offset,
                                 std::string_view message, bool with_counts);

// Images of one topic. Error (usage) too: chunks are compressed, or no message is an image.
Result<LogEnd> read_mcap(const LogBytes& log, const LogFrames& frames, const LogChoices& choices);

}  // namespace ensonify
