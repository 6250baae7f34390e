// What is measured of a data set (measure.h), block by block.
//
//   GroundRegion  MeasureSettings   ground, windows and lags
//   PatchFeatures  feature_names    of the classifier
//   BlockStatistics                 all of it
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "compare/sums.h"

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

}  // namespace ensonify
