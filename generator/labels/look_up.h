// Values of a polar image at the pixels of a Cartesian one. Private to labels/.
//
//   looked_up
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ping.h"
#include "core/vector_clones.h"

namespace ensonify {

template <class T>
void look_up(const T* polar, const std::int32_t* map, std::size_t count, T blank, T* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = map[i] >= 0 ? polar[map[i]] : blank;
}

// Several at once where the processor gathers.
void look_up(const float* polar, const std::int32_t* map, std::size_t count, float blank,
             float* to);

// [height_px x width_px], row-major; `blank` where the map is negative. Pixel by pixel in tiles:
// neighbours in a row lie far apart in the polar image, whose rows it crosses, but a tile needs no
// more of them than the processor keeps at hand.
template <class T>
std::vector<T> looked_up(const std::vector<T>& polar, T blank, const CartesianGrid& grid,
                         const std::vector<std::int32_t>& map) {
  constexpr std::size_t kTile_px = 64;
  const auto rows = static_cast<std::size_t>(grid.height_px);
  const auto columns = static_cast<std::size_t>(grid.width_px);
  std::vector<T> image;
  image.reserve(map.size());
  for (std::size_t top = 0; top < rows; top += kTile_px) {
    const std::size_t end_row = std::min(top + kTile_px, rows);
    image.resize(end_row * columns);
    for (std::size_t left = 0; left < columns; left += kTile_px) {
      const std::size_t count = std::min(kTile_px, columns - left);
      for (std::size_t row = top; row < end_row; ++row) {
        const std::size_t at = row * columns + left;
        look_up(polar.data(), map.data() + at, count, blank, image.data() + at);
      }
    }
  }
  return image;
}

}  // namespace ensonify
