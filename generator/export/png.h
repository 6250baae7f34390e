// PNG files through libpng. Private to export/.
//
//   read_grey8  read_grey16   a grey picture whose size is known
//   encode_palette            a picture of 8-bit indices
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Row-major. Error (io): not a grey PNG of this size and depth, or damaged.
Result<std::vector<std::uint8_t>> read_grey8(const std::filesystem::path& path, std::uint64_t rows,
                                             std::uint64_t columns);
Result<std::vector<std::uint16_t>> read_grey16(const std::filesystem::path& path,
                                               std::uint64_t rows, std::uint64_t columns);

using Palette = std::array<std::array<std::uint8_t, 3>, 256>;  // red, green, blue

// Needs indices.size() == rows * columns, both positive. No time stamp.
Result<std::string> encode_palette(std::span<const std::uint8_t> indices, std::uint32_t rows,
                                   std::uint32_t columns, const Palette& palette);

}  // namespace ensonify
