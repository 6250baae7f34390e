// Writing past the page cache.
#pragma once

#include <cstddef>
#include <string_view>

namespace ensonify {

// From this size on a file is worth it.
inline constexpr std::size_t kDirectBytes = 1 << 20;

struct DirectWrite {
  std::size_t written = 0;  // from the front of `bytes`; the rest is for the usual way
  int error_number = 0;     // 0, or why a write failed that the usual way would not save
};

// Writes what fills whole blocks straight to the disk, from the descriptor's offset on, which must
// be a multiple of 4096. Nothing where the file system cannot do that. Leaves the descriptor's
// flags as they were.
DirectWrite write_past_cache(int descriptor, std::string_view bytes);

}  // namespace ensonify
