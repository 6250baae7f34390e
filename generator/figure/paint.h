// Polar pictures in colours, at the pixels of a figure.
//
//   paint_values   levels and angles, by a colour map
//   paint_ids      masks
//   outline        the edges of masks, over a picture
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "figure/drawing.h"
#include "figure/fan.h"

namespace ensonify {

enum class Sampling { nearest, bilinear };

// [rows x columns], of the polar picture.
struct ValueScale {
  const ColourMap* map = nullptr;
  std::array<double, 2> limits{};  // of the map's ends, in the values' unit
  Rgb none{};                      // of NaN
};

// Outside of the fan white. Bilinear mixes amplitudes, 10^(dB/20): for levels alone.
RgbImage paint_values(std::span<const Cell> cells, int width, int height,
                      std::span<const float> values, std::uint64_t columns, const ValueScale& scale,
                      Sampling sampling);

// Ids by the nearest cell, always: between two ids there is none.
RgbImage paint_ids(std::span<const Cell> cells, int width, int height,
                   std::span<const std::uint16_t> ids, std::uint64_t columns);

// Colours the pixels around each mask, up to `thickness` pixels away: what is in it stays seen. One
// black pixel beyond parts it from a picture of its own colour.
void outline(RgbImage& image, std::span<const Cell> cells, std::span<const std::uint16_t> ids,
             std::uint64_t columns, int thickness);

}  // namespace ensonify
