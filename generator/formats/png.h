// PNG files without time stamps or other extras.
//
//   encode_png               a grayscale image with 8 or 16 bits per pixel
//   encode_png               ... or one in colors, 8 bits each
//   encode_palette_png       an image of 8-bit indices, with its colors
//   parse_png_header         size and kind, from a file's first bytes
//   parse_grey_png           a grayscale image of any size, from a file's bytes
//   parse_bright_png         the brightness of an image of any kind
//   read_grey8  read_grey16  read_rgb8   a file of a data set, whose size is known
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "formats/deflate.h"

namespace ensonify {

// Row-major [rows x columns], one channel. Needs pixels.size() == rows * columns, both positive.
Result<std::string> encode_png(std::span<const std::uint8_t> pixels, int rows, int columns);
Result<std::string> encode_png(std::span<const std::uint16_t> pixels, int rows, int columns);

using RgbPixel = std::array<std::uint8_t, 3>;  // red, green, blue
Result<std::string> encode_png(std::span<const RgbPixel> pixels, int rows, int columns);

using Palette = std::array<RgbPixel, 256>;

Result<std::string> encode_palette_png(std::span<const std::uint8_t> indices, int rows, int columns,
                                       const Palette& palette);

struct PngHeader {
  std::uint32_t width = 0, height = 0;
  int bit_depth = 0;
  int color_type = 0;  // 0: grayscale
};

// From the first 33 bytes of a file; none if it is not a PNG file.
std::optional<PngHeader> parse_png_header(std::string_view bytes);

// One of the two vectors is filled, row-major; gamma is ignored.
struct GreyPng {
  std::uint32_t rows = 0, columns = 0;
  std::vector<std::uint8_t> grey8;
  std::vector<std::uint16_t> grey16;
};

// Allocates no more pixels than the bytes can hold. Error (usage), without the file's name:
// libpng's error, or not a grayscale image of 8 or 16 bits.
Result<GreyPng> parse_grey_png(std::string_view bytes);

// Row-major, from 0 to 1: the mean of red, green and blue over the highest value that a pixel can
// have. Gamma and transparency are ignored.
struct BrightPng {
  std::uint32_t rows = 0, columns = 0;
  std::vector<float> brightness;
};

// Grayscale, palette or color, of any bit depth. Allocates no more pixels than the bytes can hold.
// Error (usage), without the file's name: libpng's error.
Result<BrightPng> parse_bright_png(std::string_view bytes);

// Row-major. Error (io): not a grayscale PNG of this size and depth, or damaged.
Result<std::vector<std::uint8_t>> read_grey8(const std::filesystem::path& path, std::uint64_t rows,
                                             std::uint64_t columns);
Result<std::vector<std::uint16_t>> read_grey16(const std::filesystem::path& path,
                                               std::uint64_t rows, std::uint64_t columns);

// Row-major, red, green and blue of each pixel. Error (io): not a PNG of 8-bit colors of this size,
// or damaged.
Result<std::vector<std::uint8_t>> read_rgb8(const std::filesystem::path& path, std::uint64_t rows,
                                            std::uint64_t columns);

}  // namespace ensonify
