// Polar planes resampled by the map of cartesian.h. Private to labels/.
//
//   resampled
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// Works in squares of the image, which need few polar rows each; `outside` where the map has no
// pixel.
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
