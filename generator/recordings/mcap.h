// ROS 2 recordings in MCAP with sonar images (ros_image.h).
//
// Layout: https://mcap.dev/spec. The file is read from its start to its end; its index is not used.
//
//   is_mcap    by the first four bytes
//   read_mcap  message by message
#pragma once

#include <string_view>

#include "recordings/log.h"

namespace ensonify {

bool is_mcap(std::string_view bytes);

// Images of one topic. Offsets of messages in a compressed chunk are those of the chunk. Error
// (usage): those of parse_ros_image, a damaged chunk, a topic with a name of more
// than 1024 bytes, or no message is an image.
Result<LogEnd> read_mcap(const LogBytes& log, const LogFrames& frames, const LogChoices& choices);

}  // namespace ensonify
