// Colors, and figures independent of pixels and SVG: boxes, lines, texts and images in painting
// order. Lengths are pixels, x to the right and y down.
//
//   colour_maps  find_colour_map   maps of even lightness, dark to light
//   colour_at                      color of a value between 0 and 1
//   id_colour                      color of an instance or class
//   RgbImage   Drawing and its items
//   encode_svg                     text stays text, images are embedded
//   draw_raster  encode_png        a drawing's pixels, by cairo, and their file
//   RasterApi  RasterEntry         the functions of the module with cairo, and the one that returns
//   kRasterModule  kRasterEntry    them
//
// cairo is in a module, libensonify_raster.so, since it brings the libraries of X11, which few
// commands need.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/error.h"

namespace ensonify {

struct Rgb8 {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

inline constexpr Rgb8 kWhite{255, 255, 255};
inline constexpr Rgb8 kNoIdColour{0xe4, 0xe4, 0xe4};

struct ColourMap {
  const char* name;
  std::array<std::uint32_t, 33> stops;  // 0xrrggbb, evenly spaced
};

std::span<const ColourMap> colour_maps();
// Null if there is none.
const ColourMap* find_colour_map(std::string_view name);

// Values are clamped to 0 and 1.
Rgb8 colour_at(const ColourMap& map, double value);

// Always the same for an id; 0 has kNoIdColour.
Rgb8 id_colour(std::uint32_t id);

struct RgbImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // row-major

  RgbImage() = default;
  RgbImage(int w, int h, Rgb8 fill);
  Rgb8 at(int x, int y) const;
  void set(std::size_t pixel, Rgb8 colour);
};

struct PlotPoint {
  double x = 0, y = 0;
};

struct DrawnBox {
  double x = 0, y = 0, width = 0, height = 0;
  Rgb8 fill;
};

struct DrawnLine {
  std::vector<PlotPoint> points;
  Rgb8 colour;
  double width = 1, opacity = 1;
};

enum class Anchor { start, middle, end };

struct DrawnText {
  double x = 0, y = 0;  // of the anchor, on the base line
  std::string text;     // UTF-8
  double size = 0;
  Anchor anchor = Anchor::start;
  bool upwards = false;  // turned by a quarter, read from below
  Rgb8 colour;
};

// One pixel of the image is one of the drawing.
struct DrawnPicture {
  int x = 0, y = 0;
  RgbImage image;
};

struct Drawing {
  int width = 0, height = 0;
  std::vector<std::variant<DrawnBox, DrawnLine, DrawnText, DrawnPicture>> items;
};

// The same drawing gives the same bytes. Characters that XML does not allow become U+FFFD.
Result<std::string> encode_svg(const Drawing& drawing);

// On white.
Result<RgbImage> draw_raster(const Drawing& drawing);

// 8 bits a channel, without date or other texts.
Result<std::string> encode_png(const RgbImage& image);

struct RasterApi {
  Result<RgbImage> (*draw)(const Drawing& drawing);   // as draw_raster
  Result<std::string> (*png)(const RgbImage& image);  // as encode_png
};

inline constexpr char kRasterModule[] = "libensonify_raster.so";
inline constexpr char kRasterEntry[] = "ensonify_raster";
using RasterEntry = const RasterApi* (*)();

}  // namespace ensonify
