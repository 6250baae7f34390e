#include "labels/annotations.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

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

// Calls visit(value, start, length) for the runs of equal values other than 0, each in one column,
// start counting down the columns.
template <class T, class Visit>
void for_each_run(const std::vector<T>& pixels, int rows, int columns, Visit&& visit) {
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows;) {
      const auto value_at = [&](int r) { return pixels[std::size_t(r) * columns + column]; };
      const T value = value_at(row);
      int end = row + 1;
      while (end < rows && value_at(end) == value) ++end;
      if (value != 0) visit(value, std::int64_t{column} * rows + row, end - row);
      row = end;
    }
  }
}

PixelMask finished(Mask& mask, std::int64_t pixels) {
  if (mask.end < pixels) mask.counts.push_back(pixels - mask.end);
  return {{mask.left, mask.top, mask.right - mask.left + 1, mask.bottom - mask.top + 1},
          mask.area,
          rle_counts(mask.counts)};
}

}  // namespace

std::vector<Annotation> annotations(const LabelledImage& image) {
  std::map<std::uint16_t, Mask> masks;
  for_each_run(image.instance, image.rows, image.columns,
               [&](std::uint16_t id, std::int64_t start, int length) {
                 add_run(masks[id], image.rows, start, length);
               });
  std::vector<Annotation> result;
  for (auto& [id, mask] : masks) {
    PixelMask pixels = finished(mask, std::int64_t{image.rows} * image.columns);
    result.push_back({id, pixels.box, pixels.area, std::move(pixels.rle_counts)});
  }
  return result;
}

std::vector<Annotation> add_amodal(const InstanceSets& amodal, std::span<const double> occlusion,
                                   std::vector<Annotation>& annotations) {
  std::map<std::uint16_t, Mask> masks;
  for_each_run(amodal.set, amodal.rows, amodal.columns,
               [&](std::uint32_t set, std::int64_t start, int length) {
                 for (const std::uint16_t id : amodal.instances(set)) {
                   add_run(masks[id], amodal.rows, start, length);
                 }
               });
  std::vector<Annotation> hidden;
  auto next = annotations.begin();
  for (auto& [id, mask] : masks) {
    while (next != annotations.end() && next->instance < id) ++next;
    Annotation* annotation = next != annotations.end() && next->instance == id ? &*next : nullptr;
    if (annotation == nullptr) {
      hidden.push_back({id, {}, 0, {}});
      annotation = &hidden.back();
    }
    annotation->amodal = finished(mask, std::int64_t{amodal.rows} * amodal.columns);
    annotation->occlusion =
        id < occlusion.size() ? occlusion[id] : std::numeric_limits<double>::quiet_NaN();
  }
  return hidden;
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
