// Compressed chunks of MCAP files. Private to recordings/.
//
//   decompressed
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"

namespace ensonify {

inline constexpr std::uint64_t kMostChunk = std::uint64_t{1} << 28;  // without compression

// `compression`: lz4 (frames) or zstd; `size`: without compression, as the chunk says. Allocates no
// more than `bytes` can hold. Error (usage), without the file's name: another compression, a size
// that cannot be, or damaged bytes.
Result<std::string> decompressed(std::string_view compression, std::string_view bytes,
                                 std::uint64_t size);

}  // namespace ensonify
