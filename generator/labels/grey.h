// Grey pictures as a person or a network sees them: 8 bits, linear in dB between two limits, or in
// amplitude up to one.
//
//   shown_gain_db         what is added to the level of each sample
//   with_gain             a polar picture's levels with it
//   grey_image            their grey
//   db_limits_from_clean  the limits where none are given
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// [samples], dB: gain_db + spreading log10(r / 1 m) + 2 alpha r, where r = n step_m; sample 0, at
// no range, has that of sample 1.
std::vector<double> shown_gain_db(const GreySettings& settings, double absorption_db_m,
                                  double step_m, int samples);

// Levels of a polar picture plus the gain of their sample; kNoEnergyDb stays.
std::vector<float> with_gain(std::span<const float> level_db, std::span<const double> gain_db);

// db: 0 at and below limits[0], 255 at and above limits[1], linear between. amplitude:
// 255 x 10^((level - limits[1]) / 20), 255 at most. Rounded to the nearest; black without energy.
GreyImage grey_image(int rows, int columns, std::span<const float> level_db, GreyScale scale,
                     const std::array<double, 2>& db_limits);

// Limits from the clean levels of pixels that hold an echo (whose elevation is known): from 10 dB
// under their 5th percentile to 6 dB (room for speckle) over their 99th, in whole dB, 40 to 80 dB
// apart; [60, 120] where nothing echoes.
std::array<double, 2> db_limits_from_clean(std::span<const float> clean_db,
                                           std::span<const float> elevation_rad);

}  // namespace ensonify
