// How far an instance stands out from the ground around it.
//
//   contrasts_db
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// For each of `annotations`, those of the polar image: 10 log10 of the mean expected power
// (`clean_power_pa2`, [beams x samples]) over the instance's pixels by that over the ground's
// pixels in its box, enlarged on every side by half its width or height, at least
// kContrastMargin_px. Ground of an instance is every other that is more than kGroundSize times as
// large; `size_m` by instance id, infinite for what always is ground. NaN where the enlarged box
// holds no ground, and where either mean is 0.
std::vector<double> contrasts_db(const LabelledImage& polar, std::span<const float> clean_power_pa2,
                                 std::span<const Annotation> annotations,
                                 std::span<const double> size_m);

inline constexpr int kContrastMargin_px = 8;
inline constexpr double kGroundSize = 10;

}  // namespace ensonify
