// PNG files through libpng. Private to export/.
//
//   encode_palette   a picture of 8-bit indices
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "core/error.h"

namespace ensonify {

using Palette = std::array<std::array<std::uint8_t, 3>, 256>;  // red, green, blue

// Needs indices.size() == rows * columns, both positive. No time stamp.
Result<std::string> encode_palette(std::span<const std::uint8_t> indices, std::uint32_t rows,
                                   std::uint32_t columns, const Palette& palette);

}  // namespace ensonify
