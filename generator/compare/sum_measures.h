// What the statistics are made of: sums of a block to ratios, levels, widths and lags. NaN: not
// defined, such as by too few pixels. Private to compare/.
//
//   ratio  ratios  decibels  bin_centers
//   mean_level  level_quantile  gray_shares  level_moments   of a table of levels
//   correlations  at_lag  at_steps  half_lag  cell_of   over the lags of the grid
//   cut_width  side_lobe  cut_levels                of the mean cut through maxima
//   inverse_shape  log_moments                      of amplitudes
//   edge_width  gain_variance  comb_ripple
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "compare/block_statistics.h"

namespace ensonify {

using Values = std::vector<double>;

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kLeastPixels = 50, kLeastMaxima = 8, kLeastEdges = 10;

double ratio(double sum, double count, double least = 1);
Values ratios(const Sums::Row& sums, const Sums::Row& counts, double least);
double decibels(double intensity);
Values bin_centers(double from, double to, int bins, double scale = 1);

double mean_level(const Sums& sums);
// The q-quantile of `empty` values below all others and those of a table, whose first step begins
// at `lowest`: of levels in dB, or of another number.
double level_quantile(const Sums::Row& levels, double empty, double q, double lowest = kLowestLevel,
                      double step = kLevelStep);
// Shares of the pixels by gray level, of kGrays levels of 1 dB from kDarkestGray over `mean`, with
// pixels without an echo and all darker ones at the first, and all brighter ones at the last.
inline constexpr int kGrays = 80, kDarkestGray = -50;
Values gray_shares(std::span<const double> levels, double empty, double mean);
// Mean and standard deviation of a table of levels.
struct LevelMoments {
  double pixels = 0, mean = kNone, spread = kNone;
};
LevelMoments level_moments(std::span<const double> levels);
// The range of the mean flattened level by beam modulo the period.
double comb_ripple(const Sums& sums, int period);

// Autocovariance at the lags of the grid, 1 at lag 0.
Values correlations(const Sums::Row& products, const Sums::Row& pairs);
double at_lag(const Values& correlation, double lag);
// At 1 to 8 steps of the settings.
Values at_steps(const Values& correlation, double step);
// Where the correlation falls to one half, in steps of the grid.
double half_lag(const Values& correlation);
// Correlated pixels in a window of 2 half + 1.
double cell_of(const Values& correlation, int half);

// -3 dB width of a cut through peaks in its middle, in steps.
double cut_width(const Sums::Row& cut, double count);
// Level of the side lobes under the peak, beyond 1.5 of the -3 dB widths of all blocks.
double side_lobe(const Sums::Row& cut, double count, const Sums::Row& all_cut, double all_count);
Values cut_levels(const Sums::Row& cut, double count);

// Of moments x0, x1, x2 of amplitudes in windows of n effective pixels.
double inverse_shape(double n, double x0, double x1, double x2);
struct LogMoments {
  double spread = kNone, skewness = kNone;
};
LogMoments log_moments(const Sums& s);

double edge_width(const Sums& s);
double gain_variance(const Sums::Row& sums, const Sums::Row& counts);

}  // namespace ensonify
