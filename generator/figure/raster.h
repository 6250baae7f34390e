// Drawings as pixels, by cairo. It is in a module, libensonify_raster.so, since cairo brings the
// libraries of X11, which few commands need.
//
//   draw_raster  encode_png                          a drawing's pixels, and their file
//   RasterApi                                        the module's functions
//   RasterEntry  kRasterModule  kRasterEntry     the module's function, which returns them
#pragma once

#include <string>

#include "core/error.h"
#include "figure/drawing.h"

namespace ensonify {

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
