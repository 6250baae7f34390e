// Images as a person or a network sees them: in Cartesian coordinates, and in grey.
//
// The Cartesian image is the fan seen from above: boresight up, port left, nearest neighbour from
// the polar image. Grey is 8 bits, linear in dB between two limits, or in amplitude up to one.
//
//   cartesian_grid             which metres a pixel stands for
//   cartesian_map              which polar pixel it shows
//   ResampledPlanes  resample  the image
//   shown_gain_db              what is added to the level of each sample
//   with_gain                  a polar image's levels with it
//   grey_image                 their grey
//   db_limits_from_clean       the limits where none are given
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// The smallest grid of `height_px` rows with square pixels that holds the whole fan.
CartesianGrid cartesian_grid(const Sonar& sonar, int height_px);

// For each Cartesian pixel, row-major, the index of the polar pixel (sample * beams + beam) whose
// sector holds its azimuth and whose sample is nearest to its range; -1 outside the fan and beyond
// the record.
std::vector<std::int32_t> cartesian_map(const CartesianGrid& grid, const Sonar& sonar,
                                        const Water& water, const Record& record);

// With `ids` the float planes of the image stay empty.
enum class ResampledPlanes { all, ids };

// Outside the fan: kNoEnergyDb, NaN angles, instance 0. A polar pixel without an elevation holds no
// label (labels/polar.h).
LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map,
                       ResampledPlanes planes = ResampledPlanes::all);

// The same of a grey picture; black outside the fan.
GreyImage resample(const GreyImage& polar, const CartesianGrid& grid,
                   const std::vector<std::int32_t>& map);

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
