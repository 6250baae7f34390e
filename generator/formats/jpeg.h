// JPEG images, for data sets of others and from them.
//
//   JpegSize  parse_grey_jpeg   the luminance of an image
//   encode_grey_jpeg  an image of one component
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Row-major; of color images the luminance.
struct GreyJpeg {
  std::uint32_t rows = 0, columns = 0;
  std::vector<std::uint8_t> grey;
};

struct JpegSize {
  std::uint64_t rows = 0, columns = 0;
};

// Allocates no more pixels than a multiple of the bytes. Error (usage), without the file's name:
// libjpeg's error, a header with more pixels than the bytes can hold or, before anything is
// decoded, an image that is not `expected`: of this size, in gray.
Result<GreyJpeg> parse_grey_jpeg(std::string_view bytes,
                                 const std::optional<JpegSize>& expected = std::nullopt);

// Baseline, without time stamps. Row-major [rows x columns], quality 1 to 100. Needs grey.size() ==
// rows * columns, both positive. Error (usage), without the file's name: libjpeg's error, such as a
// side of more than 65,500 pixels.
Result<std::string> encode_grey_jpeg(std::span<const std::uint8_t> grey, int rows, int columns,
                                     int quality);

}  // namespace ensonify
