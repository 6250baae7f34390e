#include "labels/annotations.h"

#include <algorithm>
#include <map>

namespace ensonify {
namespace {

struct Mask {
  std::vector<std::int64_t> counts;  // zeros, ones, zeros, ones, ...
  std::int64_t end = 0;              // first pixel after the last run, column-major
  std::int64_t area = 0;
  int left = 0, right = 0, top = 0, bottom = 0;
};

// Adds the run of ones [start, start + length) that lies in one column.
void add_run(Mask& mask, int rows, std::int64_t start, std::int64_t length) {
  const int column = static_cast<int>(start / rows);
  const int row = static_cast<int>(start % rows);
  const int last_row = row + static_cast<int>(length) - 1;
  if (mask.area == 0) {
    mask.left = column;
    mask.top = row;
    mask.bottom = last_row;
  }
  mask.right = column;
  mask.top = std::min(mask.top, row);
  mask.bottom = std::max(mask.bottom, last_row);
  mask.area += length;
  if (start == mask.end && !mask.counts.empty()) {
    mask.counts.back() += length;  // goes on from the foot of the column before
  } else {
    mask.counts.push_back(start - mask.end);
    mask.counts.push_back(length);
  }
  mask.end = start + length;
}

}  // namespace

std::vector<Annotation> annotations(const LabelledImage& image) {
  std::map<std::uint16_t, Mask> masks;
  for (int column = 0; column < image.columns; ++column) {
    for (int row = 0; row < image.rows;) {
      const auto id_at = [&](int r) {
        return image.instance[std::size_t(r) * image.columns + column];
      };
      const std::uint16_t id = id_at(row);
      int end = row + 1;
      while (end < image.rows && id_at(end) == id) ++end;
      if (id != 0) {
        add_run(masks[id], image.rows, std::int64_t{column} * image.rows + row, end - row);
      }
      row = end;
    }
  }
  const std::int64_t pixels = std::int64_t{image.rows} * image.columns;
  std::vector<Annotation> result;
  for (auto& [id, mask] : masks) {
    if (mask.end < pixels) mask.counts.push_back(pixels - mask.end);
    result.push_back({id,
                      {mask.left, mask.top, mask.right - mask.left + 1, mask.bottom - mask.top + 1},
                      mask.area,
                      rle_counts(mask.counts)});
  }
  return result;
}

std::string rle_counts(const std::vector<std::int64_t>& counts) {
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    std::int64_t value = counts[i] - (i > 2 ? counts[i - 2] : 0);
    for (bool more = true; more;) {
      int group = static_cast<int>(value & 0x1f);
      value >>= 5;
      // Done when what is left is only the sign, and the group's top bit says the same.
      more = (group & 0x10) ? value != -1 : value != 0;
      if (more) group |= 0x20;
      text.push_back(static_cast<char>(group + 48));
    }
  }
  return text;
}

}  // namespace ensonify
