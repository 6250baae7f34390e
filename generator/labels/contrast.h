// The expected level of an instance relative to the ground around it.
//
//   contrasts_db
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// For each of `annotations` of the polar image: 10 log10 of the mean expected power
// (`clean_power_pa2`, [beams x samples]) of the instance's pixels divided by that of the ground's
// pixels in its box. The box is enlarged on every side by half its width or height, at least by
// kContrastMargin_px. The ground of an instance consists of all other instances that are more than
// kGroundSize times as large. `size_m` is by instance id, and infinite for instances that are
// always ground. NaN if the enlarged box contains no ground, or if either mean is 0.
std::vector<double> contrasts_db(const LabelledImage& polar, std::span<const float> clean_power_pa2,
                                 std::span<const Annotation> annotations,
                                 std::span<const double> size_m);

inline constexpr int kContrastMargin_px = 8;
inline constexpr double kGroundSize = 10;

}  // namespace ensonify
