#include "labels/annotations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
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

constexpr std::size_t kRunBlock = 32;  // pixels

template <class T>
bool blocks_equal(const T* above, const T* here) {
  T bits = 0;
  for (std::size_t i = 0; i < kRunBlock; ++i) bits |= static_cast<T>(above[i] ^ here[i]);
  return bits == 0;
}

// Lists where two rows differ. Most blocks are equal; the others are searched without branches,
// which would be mispredicted.
template <class T>
std::span<const int> differences(const T* above, const T* here, std::vector<int>& columns) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < columns.size(); begin += kRunBlock) {
    const std::size_t end = std::min(begin + kRunBlock, columns.size());
    if (end == begin + kRunBlock && blocks_equal(above + begin, here + begin)) continue;
    for (std::size_t i = begin; i < end; ++i) {
      columns[count] = static_cast<int>(i);
      count += above[i] != here[i];
    }
  }
  return std::span(columns).first(count);
}

// Finds runs row by row, as the image lies in memory, and then sorts them by column.
template <class T>
ImageRuns runs_of(const std::vector<T>& pixels, int rows, int columns) {
  struct Found {
    std::uint32_t value;
    int column, row, length;
  };
  const auto width = static_cast<std::size_t>(columns);
  std::vector<Found> found;
  std::size_t count = 0;
  std::vector<int> start(width), ending(width);
  const auto end_runs = [&](const T* values, std::span<const int> which, int row) {
    if (found.size() < count + which.size()) found.resize(2 * (count + which.size()));
    for (const int column : which) {
      found[count] = {values[column], column, start[column], row - start[column]};
      count += values[column] != 0;
      start[column] = row;
    }
  };
  const T* above = pixels.data();
  for (int row = 1; row < rows; ++row, above += width) {
    end_runs(above, differences(above, above + width, ending), row);
  }
  std::iota(ending.begin(), ending.end(), 0);
  end_runs(above, ending, rows);
  found.resize(count);

  ImageRuns sorted{rows, columns, std::vector<ImageRun>(count), {}};
  std::vector<std::uint32_t> next(width + 1);  // of each column, where its next run goes
  for (const Found& run : found) ++next[static_cast<std::size_t>(run.column) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  sorted.begin = next;
  for (const Found& run : found) {
    sorted.runs[next[run.column]++] = {run.value, run.row, run.length};
  }
  return sorted;
}

// Calls visit(column, run) for all runs, column by column.
template <class Visit>
void for_each_run(const ImageRuns& image, Visit&& visit) {
  for (int column = 0; column < image.columns; ++column) {
    for (const ImageRun& run : image.of_column(column)) visit(column, run);
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

ImageRuns instance_runs(const LabelledImage& image) {
  return runs_of(image.instance, image.rows, image.columns);
}

std::vector<Annotation> annotations(const ImageRuns& image) {
  MaskTable masks;
  for_each_run(image, [&](int column, const ImageRun& run) {
    add_run(masks.of(static_cast<std::uint16_t>(run.value)), image.rows, column, run.row,
            run.length);
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
  for_each_run(runs_of(amodal.set, amodal.rows, amodal.columns),
               [&](int column, const ImageRun& run) {
                 for (const std::uint16_t id : amodal.instances(run.value)) {
                   add_run(masks.of(id), amodal.rows, column, run.row, run.length);
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

double contrast_db(const ImageRuns& polar, std::span<const float> clean_power_pa2,
                   const Annotation& annotation, std::span<const double> size_m) {
  const auto [left, top, width, height] = annotation.box;
  const Span columns = enlarged(left, width, polar.columns),
             rows = enlarged(top, height, polar.rows);
  const double least_m = kGroundSize * size_m[annotation.instance];
  Mean object, ground;
  for (int column = columns.begin; column < columns.end; ++column) {
    const float* power = clean_power_pa2.data() + std::size_t(column) * polar.rows;
    for (const ImageRun& run : polar.of_column(column)) {
      const bool is_own = run.value == annotation.instance;
      if (!is_own && !(size_m[run.value] > least_m)) continue;
      const int end = std::min(run.row + run.length, rows.end);
      for (int row = std::max(run.row, rows.begin); row < end; ++row) {
        (is_own ? object : ground).add(power[row]);
      }
    }
  }
  const double ratio = object.value() / ground.value();
  return ratio > 0 && std::isfinite(ratio) ? 10 * std::log10(ratio)
                                           : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::vector<double> contrasts_db(const ImageRuns& polar, std::span<const float> clean_power_pa2,
                                 std::span<const Annotation> annotations,
                                 std::span<const double> size_m) {
  ENSONIFY_ASSERT(clean_power_pa2.size() == std::size_t(polar.rows) * polar.columns);
  std::vector<double> contrasts;
  for (const Annotation& annotation : annotations) {
    // The largest instances have no ground: their boxes, often the whole image, are not searched.
    const bool has_ground = std::ranges::any_of(annotations, [&](const Annotation& other) {
      return size_m[other.instance] > kGroundSize * size_m[annotation.instance];
    });
    contrasts.push_back(has_ground ? contrast_db(polar, clean_power_pa2, annotation, size_m)
                                   : std::numeric_limits<double>::quiet_NaN());
  }
  return contrasts;
}

}  // namespace ensonify
