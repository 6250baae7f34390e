// WebP pictures in memory. Private to report/.
//
//   lossy_grey     speckle and the like; decoders give the codes back roughly
//   lossless_grey  lossless_rgb
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/error.h"

namespace ensonify {

// The longest side that the format has.
inline constexpr std::uint64_t kWebpMostPixels = 16383;

// Row-major [height x width]; quality 0 to 100. Grey 0 to 255 as a browser shows it.
Result<std::string> lossy_grey(std::span<const std::uint8_t> grey, int width, int height,
                               int quality);

Result<std::string> lossless_grey(std::span<const std::uint8_t> grey, int width, int height);

// 0x00RRGGBB each.
Result<std::string> lossless_rgb(std::span<const std::uint32_t> pixels, int width, int height);

}  // namespace ensonify
