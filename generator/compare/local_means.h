// Means over windows of an image. Private to compare/.
//
//   WindowSums   sums over rectangles by a summed-area table
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

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

}  // namespace ensonify
