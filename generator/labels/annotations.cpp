#include "labels/annotations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/error.h"

namespace ensonify {
namespace {

struct Mask {
  std::vector<std::int64_t> counts;  // zeros, ones, zeros, ones, ...
  std::int64_t end = 0;              // first pixel after the last run, column-major
  std::int64_t area = 0;
  int left = 0, right = 0, top = 0, bottom = 0;
};

// Adds a run of ones over `length` rows of a column, starting at `row`.
void add_run(Mask& mask, int rows, int column, int row, int length) {
  const std::int64_t start = std::int64_t{column} * rows + row;
  const int last_row = row + length - 1;
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
    mask.counts.back() += length;  // continues from the bottom of the previous column
  } else {
    mask.counts.push_back(start - mask.end);
    mask.counts.push_back(length);
  }
  mask.end = start + length;
}

template <class T>
struct ColumnRun {
  T value{};
  int row = 0, length = 0;
};

// Calls visit(i) where two rows differ. Most of a row equals the one above it and is skipped eight
// bytes at a time.
template <class T, class Visit>
void for_each_difference(const T* above, const T* here, int count, Visit&& visit) {
  constexpr int kWord = sizeof(std::uint64_t) / sizeof(T);
  int i = 0;
  for (; i + kWord <= count; i += kWord) {
    std::uint64_t a = 0, b = 0;
    std::memcpy(&a, above + i, sizeof a);
    std::memcpy(&b, here + i, sizeof b);
    if (a == b) continue;
    for (int k = i; k < i + kWord; ++k) {
      if (above[k] != here[k]) visit(k);
    }
  }
  for (; i < count; ++i) {
    if (above[i] != here[i]) visit(i);
  }
}

// The runs of equal values other than 0 in each column, found row by row, as the image lies in
// memory.
template <class T>
std::vector<std::vector<ColumnRun<T>>> column_runs(const std::vector<T>& pixels, int rows,
                                                   int columns) {
  std::vector<std::vector<ColumnRun<T>>> runs(static_cast<std::size_t>(columns));
  std::vector<int> start(runs.size());
  const auto end_run = [&](int column, T value, int row) {
    if (value != 0) runs[column].push_back({value, start[column], row - start[column]});
    start[column] = row;
  };
  const T* above = pixels.data();
  for (int row = 1; row < rows; ++row, above += columns) {
    for_each_difference(above, above + columns, columns,
                        [&](int column) { end_run(column, above[column], row); });
  }
  for (int column = 0; column < columns; ++column) end_run(column, above[column], rows);
  return runs;
}

// Calls visit(value, column, row, length) for the runs of equal values other than 0, column by
// column.
template <class T, class Visit>
void for_each_run(const std::vector<T>& pixels, int rows, int columns, Visit&& visit) {
  int column = 0;
  for (const auto& runs : column_runs(pixels, rows, columns)) {
    for (const ColumnRun<T>& run : runs) visit(run.value, column, run.row, run.length);
    ++column;
  }
}

// Masks by instance id; instances without a pixel have the area 0.
class MaskTable {
 public:
  Mask& of(std::uint16_t id) {
    if (id >= masks_.size()) masks_.resize(std::size_t{id} + 1);
    return masks_[id];
  }
  // Calls use(id, mask) in the order of the ids.
  template <class Use>
  void for_each(Use&& use) {
    for (std::size_t id = 0; id < masks_.size(); ++id) {
      if (masks_[id].area > 0) use(static_cast<std::uint16_t>(id), masks_[id]);
    }
  }

 private:
  std::vector<Mask> masks_;
};

PixelMask finished(Mask& mask, std::int64_t pixels) {
  if (mask.end < pixels) mask.counts.push_back(pixels - mask.end);
  return {{mask.left, mask.top, mask.right - mask.left + 1, mask.bottom - mask.top + 1},
          mask.area,
          rle_counts(mask.counts)};
}

}  // namespace

std::vector<Annotation> annotations(const LabelledImage& image) {
  MaskTable masks;
  for_each_run(image.instance, image.rows, image.columns,
               [&](std::uint16_t id, int column, int row, int length) {
                 add_run(masks.of(id), image.rows, column, row, length);
               });
  std::vector<Annotation> result;
  masks.for_each([&](std::uint16_t id, Mask& mask) {
    PixelMask pixels = finished(mask, std::int64_t{image.rows} * image.columns);
    result.push_back({id, pixels.box, pixels.area, std::move(pixels.rle_counts)});
  });
  return result;
}

std::vector<Annotation> add_amodal(const InstanceSets& amodal, std::span<const double> occlusion,
                                   std::vector<Annotation>& annotations) {
  MaskTable masks;
  for_each_run(amodal.set, amodal.rows, amodal.columns,
               [&](std::uint32_t set, int column, int row, int length) {
                 for (const std::uint16_t id : amodal.instances(set)) {
                   add_run(masks.of(id), amodal.rows, column, row, length);
                 }
               });
  std::vector<Annotation> hidden;
  auto next = annotations.begin();
  masks.for_each([&](std::uint16_t id, Mask& mask) {
    while (next != annotations.end() && next->instance < id) ++next;
    Annotation* annotation = next != annotations.end() && next->instance == id ? &*next : nullptr;
    if (annotation == nullptr) {
      hidden.push_back({id, {}, 0, {}});
      annotation = &hidden.back();
    }
    annotation->amodal = finished(mask, std::int64_t{amodal.rows} * amodal.columns);
    annotation->occlusion =
        id < occlusion.size() ? occlusion[id] : std::numeric_limits<double>::quiet_NaN();
  });
  return hidden;
}

std::string rle_counts(const std::vector<std::int64_t>& counts) {
  constexpr std::size_t kMostGroups = 13;  // 64 bits, five at a time
  std::string text(counts.size() * kMostGroups, '\0');
  char* out = text.data();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    std::int64_t value = counts[i] - (i > 2 ? counts[i - 2] : 0);
    for (bool more = true; more;) {
      int group = static_cast<int>(value & 0x1f);
      value >>= 5;
      // Done if only the sign is left and the top bit of the group has the same sign.
      more = (group & 0x10) ? value != -1 : value != 0;
      if (more) group |= 0x20;
      *out++ = static_cast<char>(group + 48);
    }
  }
  text.resize(static_cast<std::size_t>(out - text.data()));
  return text;
}

namespace {

struct Mean {
  double sum = 0;
  std::int64_t count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

struct Span {
  int begin = 0, end = 0;
};

Span enlarged(int first, int length, int limit) {
  const int margin = std::max(kContrastMargin_px, length / 2);
  return {std::max(0, first - margin), std::min(limit, first + length + margin)};
}

double contrast_db(const LabelledImage& polar, std::span<const float> clean_power_pa2,
                   const Annotation& annotation, std::span<const double> size_m) {
  const auto [left, top, width, height] = annotation.box;
  const Span columns = enlarged(left, width, polar.columns),
             rows = enlarged(top, height, polar.rows);
  Mean object, ground;
  for (int column = columns.begin; column < columns.end; ++column) {
    const float* power = clean_power_pa2.data() + std::size_t(column) * polar.rows;
    for (int row = rows.begin; row < rows.end; ++row) {
      const std::uint16_t id = polar.instance[std::size_t(row) * polar.columns + column];
      if (id == annotation.instance) {
        object.add(power[row]);
      } else if (size_m[id] > kGroundSize * size_m[annotation.instance]) {
        ground.add(power[row]);
      }
    }
  }
  const double ratio = object.value() / ground.value();
  return ratio > 0 && std::isfinite(ratio) ? 10 * std::log10(ratio)
                                           : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::vector<double> contrasts_db(const LabelledImage& polar, std::span<const float> clean_power_pa2,
                                 std::span<const Annotation> annotations,
                                 std::span<const double> size_m) {
  ENSONIFY_ASSERT(clean_power_pa2.size() == polar.instance.size());
  std::vector<double> contrasts;
  for (const Annotation& annotation : annotations) {
    contrasts.push_back(contrast_db(polar, clean_power_pa2, annotation, size_m));
  }
  return contrasts;
}

}  // namespace ensonify
