// Pings as figures with axes: PNG, SVG, or animated.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/error.h"

namespace ensonify {

struct FigureOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;  // its extension names the format
};

// Error kinds: usage, io, interrupted.
Status write_figure(const FigureOptions& options);

}  // namespace ensonify
