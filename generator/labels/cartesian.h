// Images in Cartesian coordinates. They show the fan from above with the boresight up and port on
// the left, and take the nearest neighbor from the polar image.
//
//   cartesian_grid             the position of a pixel in meters
//   cartesian_map              the polar pixel that it shows
//   ResampledPlanes  resample  the image
//   resampled                  the values of any plane
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// The smallest grid of `height_px` rows with square pixels that holds the whole fan.
CartesianGrid cartesian_grid(const Sonar& sonar, int height_px);

// For each Cartesian pixel, row-major, the index of the polar pixel (sample * beams + beam) whose
// beam cell contains its azimuth and whose sample is nearest to its range; -1 outside the fan and
// beyond the record.
std::vector<std::int32_t> cartesian_map(const CartesianGrid& grid, const Sonar& sonar,
                                        const Water& water, const Record& record);

// With `ids` the float planes of the image stay empty.
enum class ResampledPlanes { all, ids };

// Pixels outside the fan have kNoEnergyDb, NaN angles and instance 0. A polar pixel without an
// elevation holds no label (labels/polar.h).
LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map,
                       ResampledPlanes planes = ResampledPlanes::all);

// The same for an 8-bit image; black outside the fan.
GreyImage resample(const GreyImage& polar, const CartesianGrid& grid,
                   const std::vector<std::int32_t>& map);

// The same for the values of any plane, with `outside` where the map has no pixel. Works in squares
// of the image, which need few polar rows each.
template <class T>
std::vector<T> resampled(const std::vector<T>& polar, const CartesianGrid& grid,
                         const std::vector<std::int32_t>& map, T outside = {}) {
  constexpr int kPart_px = 64;
  std::vector<T> image(map.size(), outside);
  for (int top = 0; top < grid.height_px; top += kPart_px) {
    for (int left = 0; left < grid.width_px; left += kPart_px) {
      const int end_row = std::min(top + kPart_px, grid.height_px);
      const int end_column = std::min(left + kPart_px, grid.width_px);
      for (int row = top; row < end_row; ++row) {
        const std::size_t start = std::size_t(row) * grid.width_px;
        for (std::size_t i = start + left; i < start + end_column; ++i) {
          if (map[i] >= 0) image[i] = polar[map[i]];
        }
      }
    }
  }
  return image;
}

}  // namespace ensonify
