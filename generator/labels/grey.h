// Grey pictures as a person or a network sees them: 8 bits, linear in dB between two limits.
#pragma once

#include <array>

#include "core/ping.h"

namespace ensonify {

// 0 at and below limits[0], 255 at and above limits[1].
GreyImage grey_image(const LabelledImage& image, const std::array<double, 2>& db_limits);

// Limits from the clean levels of pixels that hold an echo (whose elevation is known): from 10 dB
// under their 5th percentile to 6 dB (room for speckle) over their 99th, in whole dB, 40 to 80 dB
// apart; [60, 120] where nothing echoes.
std::array<double, 2> db_limits_from_clean(const LabelledImage& polar);

}  // namespace ensonify
