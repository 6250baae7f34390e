// ROS 2 recordings in MCAP with sonar images (ros_image.h).
//
// Layout: https://mcap.dev/spec. The file is read from its start to its end; its index is not used.
//
//   is_mcap        by the first four bytes
//   read_mcap      message by message
//   decompressed   a compressed chunk
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"
#include "recordings/log.h"

namespace ensonify {

bool is_mcap(std::string_view bytes);

// Images of one topic. Offsets of messages in a compressed chunk are those of the chunk. Error
// (usage): those of parse_ros_image, a damaged chunk, a topic with a name of more
// than 1024 bytes, or no message is an image.
Result<LogEnd> read_mcap(const LogBytes& log, const LogFrames& frames, const LogChoices& choices);

inline constexpr std::uint64_t kMostChunk = std::uint64_t{1} << 28;  // without compression

// `compression`: lz4 (frames) or zstd; `size`: without compression, as the chunk says. Allocates no
// more than `bytes` can hold. Error (usage), without the file's name: another compression, a size
// that cannot be, or damaged bytes.
Result<std::string> decompressed(std::string_view compression, std::string_view bytes,
                                 std::uint64_t size);

}  // namespace ensonify
