#include "labels/contrast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace ensonify {
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
