// 8-bit Cartesian images of polar levels, as a sonar viewer makes them: near ranges show no grid of
// dots, and far ranges no blocks.
//
//   cartesian_gains          the time-varied gain of each pixel
//   displayed_cartesian      the gray levels
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"
#include "labels/display.h"
#include "labels/footprints.h"

namespace ensonify {

// 10^(tvg / 10) of each pixel of `to`, divided by the value at the last sample. The range is that
// of the pixel, but at least that of sample 1. Empty without time-varied gain.
std::vector<float> cartesian_gains(const DisplayTable& table, const Footprints& footprints);

// Black outside the fan and where there is no energy. `gains`: cartesian_gains; `further_gain_db`:
// the polar image's (DisplayedImage).
GreyImage displayed_cartesian(const DisplayTable& table, const Footprints& footprints,
                              std::span<const float> gains, double further_gain_db,
                              std::span<const float> level_db);

}  // namespace ensonify
