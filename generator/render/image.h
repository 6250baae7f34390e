// One 8-bit image as it is stored. Private to render/.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/display.h"
#include "core/error.h"
#include "core/ping.h"

namespace ensonify {

// Reverses columns, rows or both.
GreyImage flipped(const GreyImage& image, Flip flip);

// The image seen through a sequence's map, sample * beams + beam or -1 for each of its pixels
// [rows x columns]; black outside the fan.
GreyImage mapped(const GreyImage& polar, std::span<const std::int32_t> map, int rows, int columns);

// A PNG file: gray or, with a color map, indices into its 256 colors, which are the gray levels.
// With a quality, a JPEG file, which is gray. Needs a color map that find_colour_map knows. Error:
// that of encode_png, or an image too large for JPEG.
Result<std::string> encode_image(const GreyImage& image, const Display& display,
                                 std::uint32_t jpeg_quality = 0);

}  // namespace ensonify
