// Features of patches, for the classifier.
#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"

namespace ensonify {
namespace {

constexpr double kLeastGround = 0.95;
constexpr double kLowestInPatch = 40;  // dB under the patch's mean
constexpr double kDarkInPatch = 0.1;   // -10 dB

struct Patch {
  int row = 0, column = 0, rows = 0, columns = 0;
};

double deviation(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double v : values) sum += v;
  const double mean = sum / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

// Correlation of the patch's values with those some rows and columns on.
double correlation(const std::vector<double>& values, const Patch& patch, int rows, int columns) {
  double mean = 0, square = 0, product = 0, pairs = 0;
  for (const double v : values) mean += v;
  mean /= static_cast<double>(values.size());
  for (const double v : values) square += (v - mean) * (v - mean);
  const auto at = [&](int r, int c) {
    return values[static_cast<std::size_t>(r * patch.columns + c)] - mean;
  };
  for (int r = 0; r + rows < patch.rows; ++r) {
    for (int c = 0; c + columns < patch.columns; ++c) {
      product += at(r, c) * at(r + rows, c + columns);
      pairs += 1;
    }
  }
  if (!(square > 0) || pairs == 0) return 0;
  return product / pairs / (square / static_cast<double>(values.size()));
}

// Standard deviations of the means of rows and of columns, in dB.
std::array<double, 2> stripes(const std::vector<double>& levels, const Patch& patch) {
  std::vector<double> rows(static_cast<std::size_t>(patch.rows), 0);
  std::vector<double> columns(static_cast<std::size_t>(patch.columns), 0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double level = levels[r * columns.size() + c];
      rows[r] += level / patch.columns;
      columns[c] += level / patch.rows;
    }
  }
  return {deviation(rows), deviation(columns)};
}

// Levels with those of empty and very dark pixels lifted to a lowest one.
std::vector<double> levels_of(const std::vector<double>& intensity, double mean) {
  std::vector<double> levels;
  for (const double v : intensity) {
    levels.push_back(10 * std::log10(std::max(v / mean, std::pow(10, -kLowestInPatch / 10))));
  }
  return levels;
}

PatchFeatures features_of(const Frame& frame, const std::vector<double>& intensity,
                          const Patch& patch, double mean, double around) {
  const auto count = static_cast<double>(intensity.size());
  const std::vector<double> levels = levels_of(intensity, mean);
  std::vector<double> amplitudes;
  double second = 0, top = 0, dark = 0, level_mean = 0, skew = 0;
  for (const double v : intensity) {
    amplitudes.push_back(std::sqrt(v));
    second += v * v;
    top = std::max(top, v);
    if (v < kDarkInPatch * mean) dark += 1;
  }
  for (const double level : levels) level_mean += level / count;
  const double spread = std::max(deviation(levels), 1e-9);
  for (const double level : levels) {
    const double over = (level - level_mean) / spread;
    skew += over * over * over / count;
  }
  const auto [row_spread, column_spread] = stripes(levels, patch);
  const int row_lag = std::max(1, frame.range_lags / kLags);
  const int column_lag = std::max(1, frame.azimuth_lags / kLags);
  return {10 * std::log10(mean / around),
          spread,
          skew,
          std::log(second / count / (mean * mean)),
          correlation(amplitudes, patch, row_lag, 0),
          correlation(amplitudes, patch, 2 * row_lag, 0),
          correlation(amplitudes, patch, 0, column_lag),
          correlation(amplitudes, patch, 0, 2 * column_lag),
          row_spread,
          column_spread,
          10 * std::log10(top / mean),
          dark / count};
}

}  // namespace

std::array<std::string_view, kFeatures> feature_names() {
  return {"level over the surroundings",    "spread of the level",
          "skewness of the level",          "second moment of the intensity",
          "correlation at 1 range step",    "correlation at 2 range steps",
          "correlation at 1 azimuth step",  "correlation at 2 azimuth steps",
          "spread of the means of samples", "spread of the means of beams",
          "brightest pixel over the mean",  "share of dark pixels"};
}

void add_patches(const Frame& frame, const Picture& picture, std::vector<PatchFeatures>& patches) {
  Patch patch;
  patch.rows = std::max(4, 2 * frame.half_rows);
  patch.columns = std::max(4, 3 * frame.half_columns / 2);
  std::vector<double> intensity(static_cast<std::size_t>(patch.rows * patch.columns));
  for (patch.row = 0; patch.row + patch.rows <= frame.rows; patch.row += patch.rows) {
    for (patch.column = 0; patch.column + patch.columns <= frame.columns;
         patch.column += patch.columns) {
      double ground = 0, sum = 0;
      std::size_t k = 0;
      for (int r = patch.row; r < patch.row + patch.rows; ++r) {
        for (int c = patch.column; c < patch.column + patch.columns; ++c) {
          const std::size_t i = frame.at(r, c);
          ground += frame.ground[i];
          intensity[k] = static_cast<double>(picture.intensity[i]);
          sum += intensity[k++];
        }
      }
      const auto count = static_cast<double>(intensity.size());
      if (ground < kLeastGround * count || !(sum > 0)) continue;
      const int half_rows = 2 * patch.rows, half_columns = 2 * patch.columns;
      const double around = picture.sums
                                .around(patch.row + patch.rows / 2,
                                        patch.column + patch.columns / 2, half_rows, half_columns)
                                .mean();
      patches.push_back(features_of(frame, intensity, patch, sum / count, around));
    }
  }
}

}  // namespace ensonify
