#include "world/height_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "world/grid_file.h"

namespace ensonify {
namespace {

constexpr double kMaxLength_m = 1e7;  // as of lengths in a scenario

}  // namespace

Result<HeightGrid> load_height_grid(const std::filesystem::path& file, double cell_m, double scale,
                                    double offset_m) {
  Result<GridFile> read = load_grid_file(file);
  if (!read) return read.error();
  HeightGrid grid{read->rows, read->columns, read->cell_m > 0 ? read->cell_m : cell_m,
                  std::move(read->values)};
  const auto wrong = [&](const std::string& why) {
    return Error{ErrorKind::usage, fmt::format("{}: {}", file.string(), why)};
  };
  const double side_m = (std::max(grid.rows, grid.columns) - 1) * grid.cell_m;
  if (!(side_m <= kMaxLength_m)) {
    return wrong(
        fmt::format("its longer side is {} m, accepted are {} m at most", side_m, kMaxLength_m));
  }
  bool all_holes = true;
  for (std::size_t i = 0; i < grid.heights_m.size(); ++i) {
    double& height = grid.heights_m[i];
    if (std::isnan(height)) continue;
    all_holes = false;
    height = scale * height + offset_m;
    if (std::abs(height) <= kMaxLength_m) continue;
    return wrong(fmt::format("the height in row {}, column {} is {} m, accepted are {} m at most",
                             i / grid.columns, i % grid.columns, height, kMaxLength_m));
  }
  if (all_holes) return wrong("holds no height at all");
  return grid;
}

double height_at(const HeightGrid& grid, double x_m, double y_m) {
  const double column = x_m / grid.cell_m + 0.5 * (grid.columns - 1);
  const double row = 0.5 * (grid.rows - 1) - y_m / grid.cell_m;
  if (!(column >= 0 && column <= grid.columns - 1 && row >= 0 && row <= grid.rows - 1)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const int c = std::min(static_cast<int>(column), grid.columns - 2);
  const int r = std::min(static_cast<int>(row), grid.rows - 2);
  const double u = column - c, v = row - r;
  const double* north = &grid.heights_m[std::size_t(r) * grid.columns + c];
  const double* south = north + grid.columns;
  return (1 - v) * ((1 - u) * north[0] + u * north[1]) + v * ((1 - u) * south[0] + u * south[1]);
}

}  // namespace ensonify
