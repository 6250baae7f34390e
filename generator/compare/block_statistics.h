// What is measured of a data set (measure_blocks.h), block by block.
//
//   Sums  for_each_sum  add  subtract   of pixels, from which the statistics follow
//   GroundRegion  MeasureSettings       ground, windows and lags
//   PatchFeatures  feature_names        of the classifier
//   BlockStatistics                     all of it
//
// Sums add up over pings and blocks, so that a statistic without one block is that of all sums less
// the block's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ensonify {

struct Sums {
  using Row = std::vector<double>;

  double images = 0;
  // Levels in dB of pixels with an echo. By bins of range and azimuth, and of the grazing angle:
  Row range_level, range_count, azimuth_level, azimuth_count, grazing_level, grazing_count;
  // ... of samples that are ground in nearly all beams, by beams and samples of the grid:
  Row beam_level, beam_count, row_level, row_count;
  // Numbers of pixels by level, all and those of the farthest tenth of the ranges.
  Row levels, far_levels;
  double pixels = 0, empty = 0, far_empty = 0, top = 0;
  double distinct = 0;  // different amplitudes of an image
  // Of homogeneous pixels: moments of the normalized intensity x, and of its level in dB.
  double x0 = 0, x1 = 0, x2 = 0;
  double log0 = 0, log1 = 0, log2 = 0, log3 = 0;
  // ... by bins of range.
  Row range_x0, range_x1, range_x2;
  // Sums of (x - 1)(x' - 1) and their numbers, by lags from 0.
  Row range_products, range_pairs, azimuth_products, azimuth_pairs, ping_products, ping_pairs;
  // Bright isolated maxima: their number, and levels in dB under their peaks.
  double maxima = 0;
  Row range_cut, azimuth_cut;
  double before = 0, behind = 0, beside = 0;  // over the background
  // Dark pixels, their levels in dB relative to the surroundings, far edges of dark regions.
  double dark = 0, dark_of = 0, dark_level = 0, edges = 0;
  Row edge_profile;
  // Numbers of plain patches by their standard deviation, skewness, and correlation of neighboring
  // beams and samples (kSpreadAxis to kCorrelationAxis).
  Row plain_spread, plain_skewness, plain_beams, plain_samples;
  // Images that the comb is sought in, those that show it, and mean levels by beam from the
  // first one that is measured.
  double comb_images = 0, comb_hits = 0;
  Row comb_level;
  Row patterns;  // numbers of pixels by local binary pattern
  // Numbers of pixels by class and level: kPixelClasses tables like `levels`. Empty: no classes.
  Row class_levels;
};

template <class Left, class Right, class Use>
void for_each_sum(Left& a, Right& b, Use use) {
  const auto each = [&](auto member) { use(a.*member, b.*member); };
  for (const auto member :
       {&Sums::images,   &Sums::pixels,      &Sums::empty,    &Sums::far_empty, &Sums::top,
        &Sums::distinct, &Sums::x0,          &Sums::x1,       &Sums::x2,        &Sums::log0,
        &Sums::log1,     &Sums::log2,        &Sums::log3,     &Sums::maxima,    &Sums::before,
        &Sums::behind,   &Sums::beside,      &Sums::dark,     &Sums::dark_of,   &Sums::dark_level,
        &Sums::edges,    &Sums::comb_images, &Sums::comb_hits}) {
    each(member);
  }
  for (const auto member :
       {&Sums::range_level,   &Sums::range_count,      &Sums::azimuth_level, &Sums::azimuth_count,
        &Sums::grazing_level, &Sums::grazing_count,    &Sums::beam_level,    &Sums::beam_count,
        &Sums::row_level,     &Sums::row_count,        &Sums::levels,        &Sums::far_levels,
        &Sums::range_x0,      &Sums::range_x1,         &Sums::range_x2,      &Sums::range_products,
        &Sums::range_pairs,   &Sums::azimuth_products, &Sums::azimuth_pairs, &Sums::ping_products,
        &Sums::ping_pairs,    &Sums::range_cut,        &Sums::azimuth_cut,   &Sums::edge_profile,
        &Sums::plain_spread,  &Sums::plain_skewness,   &Sums::plain_beams,   &Sums::plain_samples,
        &Sums::comb_level,    &Sums::patterns,         &Sums::class_levels}) {
    auto& left = a.*member;
    const auto& right = b.*member;
    if (left.size() < right.size()) left.resize(right.size(), 0);
    for (std::size_t i = 0; i < right.size(); ++i) use(left[i], right[i]);
  }
}

inline void add(Sums& sums, const Sums& more) {
  for_each_sum(sums, more, [](double& a, double b) { a += b; });
}
inline void subtract(Sums& sums, const Sums& part) {
  for_each_sum(sums, part, [](double& a, double b) { a -= b; });
}

inline constexpr int kLevelRangeBins = 24, kLevelAzimuthBins = 16, kShapeBins = 6;
inline constexpr int kGrazingBins = 18;  // of 5 degrees
inline constexpr int kLags = 8, kPingLags = 4;
inline constexpr int kEdgeHalf = 8;
// Steps of the table of levels.
inline constexpr double kLevelStep = 0.5, kLowestLevel = -200;
inline constexpr int kLevelSteps = 1200;
// Tables of plain patches: of the standard deviation in dB, the skewness and the correlations.
inline constexpr int kPlainSteps = 800;
struct PlainAxis {
  double from = 0, to = 0;
  constexpr double step() const { return (to - from) / kPlainSteps; }
};
inline constexpr PlainAxis kSpreadAxis{0, 16}, kSkewnessAxis{-4, 4}, kCorrelationAxis{-1, 1};
inline constexpr int kPatterns = 256;

// By ranges and azimuths, so that any grid can be measured in it.
struct GroundRegion {
  std::vector<double> range_m, azimuth_rad;  // rising
  std::vector<std::uint8_t> is_ground;       // [range_m x azimuth_rad]
};

// Sizes of windows and steps of lags, in units of the grid: m and rad, or pixels for crops.
struct MeasureSettings {
  double range_from = 0, range_to = 0, azimuth_from = 0, azimuth_to = 0;  // of the measured region
  double range_lag = 1, azimuth_lag = 1;                                  // a step of the lags
  double range_window = 12, azimuth_window = 8;                           // half widths
  GroundRegion ground;                                                    // of pings
  bool crops = false;
  int comb_period = 8;  // beams
};

// 12 values of a patch of 24 steps in range and 12 in azimuth, free of gain.
inline constexpr std::size_t kFeatures = 12;
using PatchFeatures = std::array<double, kFeatures>;
std::array<std::string_view, kFeatures> feature_names();

struct BlockStatistics {
  MeasureSettings settings;
  double range_step = 1, azimuth_step = 1;  // of the grid
  double ping_interval_s = 0;               // median; 0: one ping a block
  int half_rows = 0, half_columns = 0;      // of the window
  std::size_t images = 0;
  std::vector<Sums> blocks;
  Sums all;                                         // of all blocks
  std::vector<std::vector<PatchFeatures>> patches;  // [blocks]
};

}  // namespace ensonify
