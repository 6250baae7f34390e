#include "render/image.h"

#include <fmt/format.h>

#include <algorithm>

#include "figure/drawing.h"
#include "formats/jpeg.h"
#include "formats/png.h"

namespace ensonify {
namespace {

Palette palette_of(const ColourMap& map) {
  Palette palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const Rgb color = colour_at(map, static_cast<double>(i) / 255);
    palette[i] = {color.red, color.green, color.blue};
  }
  return palette;
}

}  // namespace

GreyImage flipped(const GreyImage& image, Flip flip) {
  GreyImage turned = image;
  const auto columns = static_cast<std::ptrdiff_t>(image.columns);
  auto& pixels = turned.pixels;
  // Flipping both reverses the whole image.
  if (flip == Flip::both) std::reverse(pixels.begin(), pixels.end());
  for (std::ptrdiff_t row = 0; flip == Flip::horizontal && row < image.rows; ++row) {
    std::reverse(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns);
  }
  for (std::ptrdiff_t row = 0; flip == Flip::vertical && row < image.rows / 2; ++row) {
    std::swap_ranges(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns,
                     pixels.begin() + (image.rows - 1 - row) * columns);
  }
  return turned;
}

GreyImage mapped(const GreyImage& polar, std::span<const std::int32_t> map, int rows, int columns) {
  GreyImage image{rows, columns, std::vector<std::uint8_t>(map.size())};
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) image.pixels[i] = polar.pixels[static_cast<std::size_t>(map[i])];
  }
  return image;
}

Result<std::string> encode_image(const GreyImage& image, const Display& display,
                                 std::uint32_t jpeg_quality) {
  if (jpeg_quality > 0) {
    auto bytes =
        encode_grey_jpeg(image.pixels, image.rows, image.columns, static_cast<int>(jpeg_quality));
    if (bytes) return bytes;
    return Error{ErrorKind::usage,
                 fmt::format("--jpeg-quality: {} x {} pixels: {}; leave the option "
                             "out, which writes PNG files",
                             image.columns, image.rows, bytes.error().message)};
  }
  if (display.color_map.empty()) return encode_png(image.pixels, image.rows, image.columns);
  const ColourMap* map = find_colour_map(display.color_map);
  ENSONIFY_ASSERT(map != nullptr);
  return encode_palette_png(image.pixels, image.rows, image.columns, palette_of(*map));
}

}  // namespace ensonify
