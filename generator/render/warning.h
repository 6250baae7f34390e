// Checks whether a display fits the levels that it shows.
#pragma once

#include <string>

#include "core/display.h"

namespace ensonify {

inline constexpr double kMostWhite = 0.01, kMostBlack = 0.9;

// A warning if more than kMostWhite of the pixels are white, or more than kMostBlack of those with
// echoes are black (pixels without echoes always are); otherwise empty. `dataset`: the folder, as
// the user named it.
std::string display_warning(const Display& display, const DisplayCounts& counts,
                            const std::string& dataset);

}  // namespace ensonify
