#include "world/reflectivity_image.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "formats/png.h"
#include "world/grid_file.h"

namespace ensonify {
namespace {

// The two pixels around a coordinate, and the share of the second one.
struct PixelPair {
  std::array<std::size_t, 2> index{};
  double share = 0;
};

// Repeats after `count` pixels, which the coordinate runs through from 0 to 1.
PixelPair pixels_around(double coordinate, int count) {
  double within = coordinate - std::floor(coordinate);
  if (!(within >= 0)) within = 0;  // not a number: a triangle without area
  const double at = within * count - 0.5, low = std::floor(at);
  const int first = (static_cast<int>(low) + count) % count;
  return {{static_cast<std::size_t>(first), static_cast<std::size_t>((first + 1) % count)},
          at - low};
}

}  // namespace

float ReflectivityImage::at(double u, double v) const {
  const PixelPair x = pixels_around(u, columns), y = pixels_around(-v, rows);
  const auto along_x = [&](std::size_t row) {
    const float* first = factors.data() + row * static_cast<std::size_t>(columns);
    return (1 - x.share) * first[x.index[0]] + x.share * first[x.index[1]];
  };
  return static_cast<float>((1 - y.share) * along_x(y.index[0]) + y.share * along_x(y.index[1]));
}

Result<ReflectivityImage> parse_reflectivity_image(std::string_view bytes) {
  // The size is checked before memory is allocated for the pixels.
  const auto header = parse_png_header(bytes);
  if (!header) {
    return Error{ErrorKind::usage, "is not a PNG file; expected a grayscale or color image"};
  }
  if (header->width > 0 && header->height > kMaxImagePixels / header->width) {
    return Error{ErrorKind::usage,
                 fmt::format("has {} x {} pixels; expected at most {} in all: make it smaller",
                             header->width, header->height, kMaxImagePixels)};
  }
  Result<BrightPng> image = parse_bright_png(bytes);
  if (!image) return image.error();
  return ReflectivityImage{static_cast<int>(image->rows), static_cast<int>(image->columns),
                           std::move(image->brightness)};
}

Result<ReflectivityImage> load_reflectivity_image(const std::filesystem::path& file) {
  const auto named = [&](const Error& error) {
    return Error{error.kind, file.string() + ": " + error.message};
  };
  const Result<std::string> bytes = read_grid_bytes(file);
  if (!bytes) return named(bytes.error());
  Result<ReflectivityImage> image = parse_reflectivity_image(*bytes);
  if (!image) return named(image.error());
  return image;
}

}  // namespace ensonify
