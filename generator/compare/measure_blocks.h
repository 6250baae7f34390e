// Measures pings or crops, block by block.
//
//   common_settings  crop_settings   ground, bins, windows and lags, the same for both data sets
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

#include "compare/block_statistics.h"
#include "compare/pings.h"
#include "core/parallel.h"

namespace ensonify {

// Mean steps of the coarser grid, and the ranges, azimuths and ground that both have.
MeasureSettings common_settings(const PolarPings& a, const PolarPings& b, const Workers& workers);
MeasureSettings crop_settings();

BlockStatistics measure_pings(const PolarPings& pings, const MeasureSettings& settings,
                              const Workers& workers);
BlockStatistics measure_crops(const Crops& crops, const MeasureSettings& settings,
                              const Workers& workers);

}  // namespace ensonify
