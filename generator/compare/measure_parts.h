// The parts of a measurement, each of one image. Private to compare/.
//
//   Frame       what all images of a grid share
//   Picture  picture_of                  an image with its normalized intensity
//   add_levels  add_texture  add_ping_pairs  add_maxima  add_darkness  add_patches
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "compare/block_statistics.h"
#include "compare/local_means.h"
#include "compare/pings.h"

namespace ensonify {

struct Frame {
  MeasureSettings settings;
  int rows = 0, columns = 0;
  int half_rows = 0, half_columns = 0;    // of the window
  int guard_rows = 0, guard_columns = 0;  // of an echo in it
  int range_lags = 0, azimuth_lags = 0;   // of the grid
  // [rows x columns], 0 or 1.
  std::vector<std::uint8_t> measured, ground;
  // Bins of rows and columns; -1: none. Empty for crops.
  std::vector<int> range_bin, azimuth_bin, shape_bin;
  std::vector<std::uint8_t> is_far;    // [rows]
  std::vector<std::uint8_t> is_whole;  // [rows]: nine tenths or more of the row are ground
  std::vector<double> range_m;         // [rows]; empty for crops
  float top = 0;                       // largest amplitude of all images

  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  bool has(int row, int column) const {
    return row >= 0 && row < rows && column >= 0 && column < columns;
  }
};

// x of a pixel that is not homogeneous.
inline constexpr float kNoValue = -1;

struct Picture {
  GridImage image;
  std::vector<float> intensity;
  std::vector<float> level;  // dB; without an echo: the lowest of the image
  std::vector<float> x;      // kNoValue where it is not defined
  WindowSums sums;           // of the intensity of measured pixels
  WindowSums levels;         // ... of their levels
};

Picture picture_of(const Frame& frame, const GridImage& image);

void add_levels(const Frame& frame, const Picture& picture, double height_m, Sums& sums);
void add_texture(const Frame& frame, const Picture& picture, Sums& sums);
// Of two images of a block, `lag` pings apart, by their x.
void add_ping_pairs(const std::vector<float>& x, const std::vector<float>& later, int lag,
                    Sums& sums);
void add_maxima(const Frame& frame, const Picture& picture, Sums& sums);
void add_darkness(const Frame& frame, const Picture& picture, Sums& sums);
void add_patches(const Frame& frame, const Picture& picture, std::vector<PatchFeatures>& patches);

}  // namespace ensonify
