// The parts of a measurement, each of one image. Private to compare/.
//
//   WindowSums  sums over rectangles by a summed-area table
//   Frame       what all images of a grid share
//   Picture  picture_of                  an image with its normalized intensity
//   add_levels  add_texture  add_ping_pairs  add_maxima  add_darkness  add_patches
//   add_plain_patches  add_comb  flattened  add_patterns  add_classes   as others measure images
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "compare/block_statistics.h"
#include "compare/pings.h"

namespace ensonify {

// Sums of values and numbers of pixels over rectangles, of the pixels that are used.
class WindowSums {
 public:
  // [rows x columns], row-major. A pixel is used unless `used` has a 0.
  template <class Value>
  WindowSums(std::span<const Value> values, std::span<const std::uint8_t> used, int rows,
             int columns)
      : rows_(rows), columns_(columns) {
    const auto width = static_cast<std::size_t>(columns) + 1;
    sums_.assign(width * (static_cast<std::size_t>(rows) + 1), {});
    for (int r = 0; r < rows; ++r) {
      Cell line;
      for (int c = 0; c < columns; ++c) {
        const auto i = static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
                       static_cast<std::size_t>(c);
        if (used[i] != 0) {
          line.sum += static_cast<double>(values[i]);
          line.count += 1;
        }
        const Cell& above = sums_[at(r, c + 1)];
        sums_[at(r + 1, c + 1)] = {above.sum + line.sum, above.count + line.count};
      }
    }
  }

  struct Cell {
    double sum = 0, count = 0;
    Cell operator-(const Cell& other) const { return {sum - other.sum, count - other.count}; }
    double mean() const { return count > 0 ? sum / count : 0; }
  };

  // Rows first_row to last_row and columns likewise, ends included, cut at the image's rim.
  Cell rectangle(int first_row, int last_row, int first_column, int last_column) const {
    const int r0 = std::max(first_row, 0), r1 = std::min(last_row, rows_ - 1);
    const int c0 = std::max(first_column, 0), c1 = std::min(last_column, columns_ - 1);
    if (r0 > r1 || c0 > c1) return {};
    const Cell &a = sums_[at(r0, c0)], &b = sums_[at(r0, c1 + 1)], &c = sums_[at(r1 + 1, c0)],
               &d = sums_[at(r1 + 1, c1 + 1)];
    return {d.sum - b.sum - c.sum + a.sum, d.count - b.count - c.count + a.count};
  }
  Cell around(int row, int column, int half_rows, int half_columns) const {
    return rectangle(row - half_rows, row + half_rows, column - half_columns,
                     column + half_columns);
  }

 private:
  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row) * (static_cast<std::size_t>(columns_) + 1) +
           static_cast<std::size_t>(column);
  }
  int rows_, columns_;
  std::vector<Cell> sums_;
};

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
void add_plain_patches(const Frame& frame, const Picture& picture, Sums& sums);
void add_comb(const Frame& frame, const Picture& picture, Sums& sums);
void add_patterns(const Frame& frame, const Picture& picture, Sums& sums);
void add_classes(const Frame& frame, const Picture& picture, Sums& sums);

// Values by beam less their Gaussian mean of 6 beams standard deviation, without 4 beams at each
// end. Needs kLeastCombBeams or more.
std::vector<double> flattened(std::span<const double> line);
inline constexpr std::size_t kLeastCombBeams = 32;

}  // namespace ensonify
