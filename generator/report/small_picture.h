// Reduced images of a ping's levels, for pages with many of them. Private to report/.
//
//   Blocks                       along a side of an image that is reduced
//   has_levels  levels_of_ping
//   SmallPicture  smaller  picture_json
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/error.h"
#include "formats/json.h"
#include "report/pictures.h"

namespace ensonify {

// Blocks of equal size along a side of an image.
struct Blocks {
  Blocks(std::size_t all_pixels, std::size_t most)
      : all(all_pixels), size((all + most - 1) / most), count((all + size - 1) / size) {}
  std::size_t all, size, count;

  std::pair<std::size_t, std::size_t> range(std::size_t block) const {
    return {block * size, std::min(all, (block + 1) * size)};
  }
  // The mean of what stands at even distances.
  double mean(const std::vector<double>& values, std::size_t block) const {
    const auto [first, end] = range(block);
    return (values[first] + values[end - 1]) / 2;
  }
};

// Whether there is a polar image or a time series.
bool has_levels(const StoredSequence& sequence);

// [samples x beams], dB; needs has_levels. Errors (io): as pixels_of.
Result<std::vector<float>> levels_of_ping(const StoredDataset& dataset, const ShownSequence& shown,
                                          std::uint32_t ping, const Workers& workers);

// Levels [rows x columns], nearest range first; a pixel has the highest level of those that it
// stands for.
struct SmallPicture {
  std::size_t rows = 0, columns = 0;
  double first_range_m = 0, range_step_m = 0;  // of rows
  std::vector<double> azimuth_rad;             // of columns
  std::vector<float> level_db;
};

// At most `side` rows and columns of level_db [samples x beams].
SmallPicture smaller(const ShownSequence& shown, const std::vector<float>& level_db,
                     std::size_t side);

// The geometry, and the number of the chunk with the codes of the levels.
Result<Json> picture_json(const SmallPicture& picture, const PictureScale& scale, Chunks& chunks);

}  // namespace ensonify
