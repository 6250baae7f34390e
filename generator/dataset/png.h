// Grey PNG files in memory, without time stamps or other extras.
//
//   encode_png    8 or 16 bits a pixel
//   parse_png_header
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/error.h"
#include "dataset/deflate.h"

namespace ensonify {

// Row-major [rows x columns], one channel. Needs pixels.size() == rows * columns, both positive.
Result<std::string> encode_png(std::span<const std::uint8_t> pixels, int rows, int columns,
                               Content content);
Result<std::string> encode_png(std::span<const std::uint16_t> pixels, int rows, int columns,
                               Content content);

struct PngHeader {
  std::uint32_t width = 0, height = 0;
  int bit_depth = 0;
  int color_type = 0;  // 0: grey
};

// From the first 33 bytes of a file; none if they are not those of a PNG file.
std::optional<PngHeader> parse_png_header(std::string_view bytes);

}  // namespace ensonify
