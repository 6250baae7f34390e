#include "figure/fan.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

// Half a cell beyond the outer centres belongs to the outer cells.
Cell cell_at(const PolarFan& fan, double row, double column) {
  const auto rows = static_cast<double>(fan.samples), columns = static_cast<double>(fan.beams);
  if (!(row >= -0.5 && row < rows - 0.5 && column >= -0.5 && column < columns - 0.5)) return {};
  return {static_cast<float>(std::clamp(row, 0.0, rows - 1)),
          static_cast<float>(std::clamp(column, 0.0, columns - 1))};
}

}  // namespace

double PolarFan::min_range_m() const { return std::max(0.0, first_range_m - step_m / 2); }

std::uint64_t Cell::nearest(std::uint64_t columns) const {
  return static_cast<std::uint64_t>(row + 0.5f) * columns +
         static_cast<std::uint64_t>(column + 0.5f);
}

Extent cartesian_extent(const PolarFan& fan) {
  const double low = std::max(fan.min_azimuth_rad(), -kPi);
  const double high = std::min(fan.max_azimuth_rad(), kPi);
  std::vector<double> corners = {low, high};
  for (const double turn : {-kPi, -kPi / 2, 0.0, kPi / 2, kPi}) {
    if (turn > low && turn < high) corners.push_back(turn);
  }
  Extent extent;
  for (const double azimuth : corners) {
    const double port = fan.max_range_m() * std::sin(azimuth);
    const double ahead = fan.max_range_m() * std::cos(azimuth);
    extent.left = std::max(extent.left, port);
    extent.right = std::min(extent.right, port);
    extent.top = std::max(extent.top, ahead);
    extent.bottom = std::min(extent.bottom, ahead);
  }
  return extent;
}

Extent polar_extent(const PolarFan& fan) {
  return {degrees(fan.min_azimuth_rad()), degrees(fan.max_azimuth_rad()), fan.max_range_m(),
          fan.min_range_m()};
}

std::vector<Cell> cartesian_cells(const PolarFan& fan, const Extent& extent, int width,
                                  int height) {
  std::vector<Cell> cells;
  cells.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const double ahead = extent.top + (extent.bottom - extent.top) * (y + 0.5) / height;
    for (int x = 0; x < width; ++x) {
      const double port = extent.left + (extent.right - extent.left) * (x + 0.5) / width;
      cells.push_back(cell_at(fan, (std::hypot(port, ahead) - fan.first_range_m) / fan.step_m,
                              (std::atan2(port, ahead) - fan.first_azimuth_rad) / fan.spacing_rad));
    }
  }
  return cells;
}

std::vector<Cell> polar_cells(const PolarFan& fan, int width, int height) {
  std::vector<Cell> cells;
  cells.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const double from = (fan.min_range_m() - fan.first_range_m) / fan.step_m;
  const double rows = static_cast<double>(fan.samples) - 0.5 - from;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      cells.push_back(cell_at(fan, from + rows * (y + 0.5) / height,
                              static_cast<double>(fan.beams) * (x + 0.5) / width - 0.5));
    }
  }
  return cells;
}

}  // namespace ensonify
