// Numbers on a regular grid, from files. Private to world/.
//
//   GridFile  load_grid_file  read_grid_bytes
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

inline constexpr std::int64_t kMaxGridCells = 64'000'000;

// At least two rows and columns; the first row is the northernmost.
struct GridFile {
  int rows = 0, columns = 0;
  std::vector<double> values;  // row-major, as in the file; NaN: no value
  double white = 0;            // of PNG: the highest value that a pixel can have
  double cell_m = 0;           // of ESRI ASCII
};

// Reads NPY of two dimensions (integers, float32 or float64, with either order of bytes and axes),
// grayscale PNG of 8 or 16 bits (gamma is ignored), or ESRI ASCII. The extension determines the
// format. Errors: usage, `file: what is wrong; what is expected`; io if the file cannot be read.
Result<GridFile> load_grid_file(const std::filesystem::path& file);

// The bytes of a file of at most 2 GiB. Errors as above, without the file's name.
Result<std::string> read_grid_bytes(const std::filesystem::path& file);

// As load_grid_file, from a file's bytes. Errors do not contain the file's name.
Result<GridFile> parse_npy_grid(std::string_view bytes);
Result<GridFile> parse_png_grid(std::string_view bytes);
Result<GridFile> parse_asc_grid(std::string_view bytes);

// Whether a grid of this size is allowed.
Status check_grid_size(std::int64_t rows, std::int64_t columns);

}  // namespace ensonify
