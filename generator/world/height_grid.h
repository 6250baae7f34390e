// Heights over a regular grid.
//
//   HeightGrid         column_x_m row_y_m
//   load_height_grid   from a file
//   height_at          between the grid's points
#pragma once

#include <filesystem>
#include <vector>

#include "core/error.h"

namespace ensonify {

// Points `cell_m` apart, two rows and columns at least, centred at the origin: columns from west
// (x least) to east, rows from north (y largest) to south.
struct HeightGrid {
  int rows = 0, columns = 0;
  double cell_m = 0;
  std::vector<double> heights_m;  // row-major; NaN: a hole
};

inline double column_x_m(const HeightGrid& grid, int column) {
  return (column - 0.5 * (grid.columns - 1)) * grid.cell_m;
}
inline double row_y_m(const HeightGrid& grid, int row) {
  return (0.5 * (grid.rows - 1) - row) * grid.cell_m;
}

// height = scale * value + offset. `cell_m` is not looked at for ESRI ASCII, whose corner is not
// either. Holes: NODATA of ESRI ASCII, NaN of NPY.
// Errors: those of load_grid_file, and heights or sides beyond 1e7 m.
Result<HeightGrid> load_height_grid(const std::filesystem::path& file, double cell_m, double scale,
                                    double offset_m);

// Bilinear; NaN outside of the grid and in cells with a hole.
double height_at(const HeightGrid& grid, double x_m, double y_m);

}  // namespace ensonify
