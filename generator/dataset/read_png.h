// Grey PNG files whose size is known, read through libpng.
//
//   read_grey8  read_grey16
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Row-major. Error (io): not a grey PNG of this size and depth, or damaged.
Result<std::vector<std::uint8_t>> read_grey8(const std::filesystem::path& path, std::uint64_t rows,
                                             std::uint64_t columns);
Result<std::vector<std::uint16_t>> read_grey16(const std::filesystem::path& path,
                                               std::uint64_t rows, std::uint64_t columns);

}  // namespace ensonify
