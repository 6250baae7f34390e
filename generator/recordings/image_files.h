// The counts of one image of a folder that recording.yaml describes (images.h).
//
//   LogImage  read_log_image   a polar image as it is
//   FanDisplay  read_display   the display of a fan, made polar
//
// A display shows the fan as it lies in space, with one scale of ranges: cell (range r, azimuth a,
// port positive) is at apex + r pixels_per_m (-sin a, -cos a) in columns and rows if the fan looks
// up. Its value is interpolated bilinearly between the middles of the pixels, (column + 1/2, row +
// 1/2), and rounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "core/error.h"

namespace ensonify {

// Little-endian, row-major.
struct LogImage {
  std::uint64_t rows = 0, columns = 0;
  int bits = 8;
  std::string counts;
};

// A grayscale PNG, or an NPY file of uint8 or uint16. Error (usage): another kind of file, or
// larger than 256 MiB; (io): it cannot be read.
Result<LogImage> read_log_image(const std::filesystem::path& path);

enum class FanLook { up, right, down, left };  // where the middle of the fan points

struct FanDisplay {
  double apex_column = 0, apex_row = 0;  // may lie outside the image
  double pixels_per_m = 0;
  FanLook look = FanLook::up;
  bool mirrored = false;  // port is where starboard would be
};

// Cells for all ranges and azimuths, in their order: [ranges x azimuths] of 8 bits. The image is a
// PNG or a JPEG file, of which colors become their brightness. Error (usage): another kind of file,
// or a cell that lies outside of the image; (io): it cannot be read.
Result<LogImage> read_display(const std::filesystem::path& path, const FanDisplay& display,
                              std::span<const double> range_m, std::span<const double> azimuth_rad);

}  // namespace ensonify
