// What tells the instrument: the comb of beams that fire in groups, local binary patterns, and
// levels by classes of pixels.
//
// The comb of a sonar that fires every G-th beam at once: the samples whose mean levels are the
// highest tenth are averaged and flattened over the beams. The contrast is the autocorrelation at G
// beams less the mean of those at G - 1 and G + 1.
#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"
#include "core/error.h"

namespace ensonify {
namespace {

constexpr double kSmooth = 6;  // beams
constexpr int kReach = 24, kEnds = 4;
constexpr double kBrightRows = 0.9, kContrast = 0.5;

// Mean levels by row and by column of the measured pixels.
struct LineMeans {
  std::vector<double> rows;                // of rows with measured pixels
  std::vector<int> places;                 // ... which they are
  int first_column = 0, last_column = -1;  // that have measured pixels
};

LineMeans line_means(const Frame& frame, const Picture& picture) {
  LineMeans means;
  means.first_column = frame.columns;
  for (int r = 0; r < frame.rows; ++r) {
    double sum = 0, count = 0;
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      if (frame.measured[i] == 0) continue;
      sum += static_cast<double>(picture.level[i]);
      count += 1;
      means.first_column = std::min(means.first_column, c);
      means.last_column = std::max(means.last_column, c);
    }
    if (count == 0) continue;
    means.rows.push_back(sum / count);
    means.places.push_back(r);
  }
  return means;
}

// Means over the measured pixels of some rows; empty: a column has none.
std::vector<double> column_means(const Frame& frame, const Picture& picture,
                                 const std::vector<int>& rows, int first, int last) {
  std::vector<double> sums(static_cast<std::size_t>(last - first + 1), 0), counts(sums.size(), 0);
  for (const int r : rows) {
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const std::size_t i = frame.at(r, first) + k;
      if (frame.measured[i] == 0) continue;
      sums[k] += static_cast<double>(picture.level[i]);
      counts[k] += 1;
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (counts[k] == 0) return {};
    sums[k] /= counts[k];
  }
  return sums;
}

std::vector<int> bright_rows(const LineMeans& means) {
  std::vector<double> sorted = means.rows;
  std::sort(sorted.begin(), sorted.end());
  const double place = kBrightRows * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const double above = sorted[std::min(below + 1, sorted.size() - 1)];
  const double least = sorted[below] + (place - std::floor(place)) * (above - sorted[below]);
  std::vector<int> rows;
  for (std::size_t k = 0; k < means.rows.size(); ++k) {
    if (means.rows[k] >= least) rows.push_back(means.places[k]);
  }
  return rows;
}

double mean_product(const std::vector<double>& values, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = 0; i + lag < values.size(); ++i) sum += values[i] * values[i + lag];
  return sum / static_cast<double>(values.size() - lag);
}

// One bit for each of the 8 neighbors that is at least as high.
int pattern_of(const float* above, const float* line, const float* below) {
  const float center = line[1];
  return (above[0] >= center) | (above[1] >= center) << 1 | (above[2] >= center) << 2 |
         (line[2] >= center) << 3 | (below[2] >= center) << 4 | (below[1] >= center) << 5 |
         (below[0] >= center) << 6 | (line[0] >= center) << 7;
}

}  // namespace

std::vector<double> flattened(std::span<const double> line) {
  const int beams = static_cast<int>(line.size());
  ENSONIFY_ASSERT(line.size() >= kLeastCombBeams);
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -kReach; k <= kReach; ++k) {
    kernel.push_back(std::exp(-0.5 * (k / kSmooth) * (k / kSmooth)));
    sum += kernel.back();
  }
  std::vector<double> flat;
  for (int i = kEnds; i < beams - kEnds; ++i) {
    double mean = 0;
    for (int k = -kReach; k <= kReach; ++k) {
      // Reflected at the first and the last beam.
      const int at = std::abs(i + k), inside = at < beams ? at : 2 * (beams - 1) - at;
      mean += kernel[static_cast<std::size_t>(k + kReach)] * line[static_cast<std::size_t>(inside)];
    }
    flat.push_back(line[static_cast<std::size_t>(i)] - mean / sum);
  }
  return flat;
}

void add_comb(const Frame& frame, const Picture& picture, Sums& sums) {
  const LineMeans means = line_means(frame, picture);
  const int first = means.first_column, last = means.last_column;
  const auto period = static_cast<std::size_t>(frame.settings.comb_period);
  const auto beams = static_cast<std::size_t>(std::max(0, last - first + 1));
  if (beams < kLeastCombBeams || beams < 2 * period + 2 * kEnds) return;
  const auto all = column_means(frame, picture, means.places, first, last);
  const auto bright = column_means(frame, picture, bright_rows(means), first, last);
  if (all.empty() || bright.empty()) return;
  const std::vector<double> flat = flattened(bright);
  const double power = mean_product(flat, 0);
  if (!(power > 0)) return;
  const auto near = (mean_product(flat, period - 1) + mean_product(flat, period + 1)) / 2;
  sums.comb_images += 1;
  if (mean_product(flat, period) - near > kContrast * power) sums.comb_hits += 1;
  sums.comb_level.resize(beams, 0);
  for (std::size_t k = 0; k < beams; ++k) sums.comb_level[k] += all[k];
}

void add_patterns(const Frame& frame, const Picture& picture, Sums& sums) {
  std::vector<std::uint32_t> counts(kPatterns, 0);
  for (int r = 1; r + 1 < frame.rows; ++r) {
    const float* above = picture.level.data() + frame.at(r - 1, 0);
    const float* line = picture.level.data() + frame.at(r, 0);
    const float* below = picture.level.data() + frame.at(r + 1, 0);
    const std::uint8_t* measured = frame.measured.data() + frame.at(r, 1);
    for (int c = 0; c + 2 < frame.columns; ++c) {
      const int pattern = pattern_of(above + c, line + c, below + c);
      counts[static_cast<std::size_t>(pattern)] += measured[c];
    }
  }
  sums.patterns.assign(counts.begin(), counts.end());
}

void add_classes(const Frame& frame, const Picture& picture, Sums& sums) {
  if (picture.image.classes.empty()) return;
  sums.class_levels.resize(static_cast<std::size_t>(kPixelClasses) * kLevelSteps, 0);
  for (std::size_t i = 0; i < picture.level.size(); ++i) {
    if (frame.measured[i] == 0 || !(picture.image.amplitude[i] > 0)) continue;
    const double step = (static_cast<double>(picture.level[i]) - kLowestLevel) / kLevelStep;
    sums.class_levels[picture.image.classes[i] * std::size_t{kLevelSteps} +
                      static_cast<std::size_t>(std::clamp(step, 0.0, kLevelSteps - 1.0))] += 1;
  }
}

}  // namespace ensonify
