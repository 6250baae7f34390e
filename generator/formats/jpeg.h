// JPEG images as they are found in data sets of others.
//
//   parse_grey_jpeg   the luminance of an image
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Row-major; of color images the luminance.
struct GreyJpeg {
  std::uint32_t rows = 0, columns = 0;
  std::vector<std::uint8_t> grey;
};

// Allocates no more pixels than a multiple of the bytes. Error (usage), without the file's name:
// libjpeg's error, or a header with more pixels than the bytes can hold.
Result<GreyJpeg> parse_grey_jpeg(std::string_view bytes);

}  // namespace ensonify
