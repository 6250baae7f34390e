// Pings as figures with axes: PNG, SVG, or animated.
//
//   write_figure
//   colour_map_list   names of the color maps, for messages
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/error.h"
#include "figure/frames.h"

namespace ensonify {

struct FigureReport {
  std::uint64_t frames = 0;
  std::optional<std::array<double, 2>> limits;  // of the color bar
};

std::string colour_map_list();

// Errors: (usage) not a finished data set, an option that does not fit it, or no ffmpeg; (io)
// reading or writing failed, or ffmpeg failed; (interrupted). The output appears whole or not at
// all.
Result<FigureReport> write_figure(const FigureOptions& options);

}  // namespace ensonify
