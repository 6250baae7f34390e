// A figure before it is pixels or SVG: boxes, lines, texts and pictures in the order in which they
// are painted. Lengths are pixels, x to the right and y down.
//
//   RgbImage   Drawing and its items
//   draw_raster   encode_png   pixels
//   encode_svg                 text stays text, pictures are embedded
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "figure/colour_map.h"

namespace ensonify {

struct RgbImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // row-major

  RgbImage() = default;
  RgbImage(int w, int h, Rgb fill);
  Rgb at(int x, int y) const;
  void set(std::size_t pixel, Rgb colour);
};

struct PlotPoint {
  double x = 0, y = 0;
};

struct DrawnBox {
  double x = 0, y = 0, width = 0, height = 0;
  Rgb fill;
};

struct DrawnLine {
  std::vector<PlotPoint> points;
  Rgb colour;
  double width = 1, opacity = 1;
};

enum class Anchor { start, middle, end };

struct DrawnText {
  double x = 0, y = 0;  // of the anchor, on the base line
  std::string text;     // UTF-8
  double size = 0;
  Anchor anchor = Anchor::start;
  bool upwards = false;  // turned by a quarter, read from below
  Rgb colour;
};

// One pixel of the picture is one of the drawing.
struct DrawnPicture {
  int x = 0, y = 0;
  RgbImage image;
};

struct Drawing {
  int width = 0, height = 0;
  std::vector<std::variant<DrawnBox, DrawnLine, DrawnText, DrawnPicture>> items;
};

// On white.
Result<RgbImage> draw_raster(const Drawing& drawing);

// 8 bits a channel, without date or other texts.
Result<std::string> encode_png(const RgbImage& image);

// The same drawing gives the same bytes. Characters that XML does not allow become U+FFFD.
Result<std::string> encode_svg(const Drawing& drawing);

}  // namespace ensonify
