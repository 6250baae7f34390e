// Measures pings or crops, block by block.
//
//   GroundRegion  MeasureSettings  common_settings   ground, bins, windows and lags, the same for
//                                                    both data sets
//   PatchFeatures                            of the classifier
//   BlockStatistics                          what is measured
//   measure_pings  measure_crops
//
// Local normalization: x = I / <I>, the intensity over its mean in a window around the pixel, which
// is included. For N independent exponential pixels in the window, x/N has the beta distribution
// (1, N - 1): E x = 1, E x^2 = 2N/(N + 1), which statistics.h corrects. Windows that lie for less
// than three quarters in the region are not used.
//
// The ground of a data set is the region whose intensity, averaged over all pings and half a
// window, is 6 dB above the noise floor, or no more than 10 dB under the median pixel if that is
// lower. The noise floor is the lowest mean over azimuth and 9 samples. Both data sets are measured
// where both have ground, less half a window along the rim: if each had its own region, the rim
// would differ by chance, and with it what is measured. A pixel is homogeneous if it is ground, if
// its window holds no pixel 20 dB or more over the mean level of the surroundings (a window of 2.5
// times the size around that pixel), and if the mean levels of its window and its surroundings
// differ by 3 dB or less.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "compare/pings.h"
#include "compare/sums.h"
#include "core/parallel.h"

namespace ensonify {

inline constexpr int kLevelRangeBins = 24, kLevelAzimuthBins = 16, kShapeBins = 6;
inline constexpr int kGrazingBins = 18;  // of 5 degrees
inline constexpr int kLags = 8, kPingLags = 4;
inline constexpr int kEdgeHalf = 8;
// Steps of the table of levels.
inline constexpr double kLevelStep = 0.5, kLowestLevel = -200;
inline constexpr int kLevelSteps = 1200;

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
};

// Mean steps of the coarser grid, and the ranges, azimuths and ground that both have.
MeasureSettings common_settings(const PolarPings& a, const PolarPings& b, const Workers& workers);
MeasureSettings crop_settings();

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
  double ground_share = 0;  // of the measured pixels
  std::vector<Sums> blocks;
  Sums all;                                         // of all blocks
  std::vector<std::vector<PatchFeatures>> patches;  // [blocks]
};

BlockStatistics measure_pings(const PolarPings& pings, const MeasureSettings& settings,
                              const Workers& workers);
BlockStatistics measure_crops(const Crops& crops, const MeasureSettings& settings,
                              const Workers& workers);

}  // namespace ensonify
