#include "figure/paint.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"

namespace ensonify {
namespace {

// Half a cell beyond the outer centers belongs to the outer cells.
Cell cell_at(const PolarFan& fan, double row, double column) {
  const auto rows = static_cast<double>(fan.samples), columns = static_cast<double>(fan.beams);
  if (!(row >= -0.5 && row < rows - 0.5 && column >= -0.5 && column < columns - 0.5)) return {};
  return {static_cast<float>(std::clamp(row, 0.0, rows - 1)),
          static_cast<float>(std::clamp(column, 0.0, columns - 1))};
}

constexpr Rgb8 kBlack{};

double amplitude(float level_db) {
  return level_db > kNoEnergyDb ? std::pow(10.0, level_db / 20) : 0;
}

float bilinear_db(std::span<const float> values, std::uint64_t columns, const Cell& cell) {
  const std::uint64_t rows = values.size() / columns;
  const auto row = static_cast<std::uint64_t>(cell.row);
  const auto column = static_cast<std::uint64_t>(cell.column);
  const std::uint64_t below = std::min(row + 1, rows - 1),
                      beside = std::min(column + 1, columns - 1);
  const double down = cell.row - static_cast<double>(row);
  const double right = cell.column - static_cast<double>(column);
  const auto at = [&](std::uint64_t r, std::uint64_t c) {
    return amplitude(values[r * columns + c]);
  };
  const double upper = (1 - right) * at(row, column) + right * at(row, beside);
  const double lower = (1 - right) * at(below, column) + right * at(below, beside);
  const double mixed = (1 - down) * upper + down * lower;
  return mixed > 0 ? static_cast<float>(20 * std::log10(mixed)) : kNoEnergyDb;
}

}  // namespace

double PolarFan::min_azimuth_rad() const {
  if (azimuth_rad.size() < 2) return first_azimuth_rad - spacing_rad / 2;
  return azimuth_rad[0] - (azimuth_rad[1] - azimuth_rad[0]) / 2;
}

double PolarFan::max_azimuth_rad() const {
  if (azimuth_rad.size() < 2) {
    return first_azimuth_rad + (static_cast<double>(beams) - 0.5) * spacing_rad;
  }
  return azimuth_rad.back() + (azimuth_rad.back() - azimuth_rad[azimuth_rad.size() - 2]) / 2;
}

double PolarFan::column_at(double azimuth) const {
  if (azimuth_rad.size() < 2) return (azimuth - first_azimuth_rad) / spacing_rad;
  const auto above = std::upper_bound(azimuth_rad.begin() + 1, azimuth_rad.end() - 1, azimuth);
  const double low = *(above - 1);
  return static_cast<double>(above - 1 - azimuth_rad.begin()) + (azimuth - low) / (*above - low);
}

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
                              fan.column_at(std::atan2(port, ahead))));
    }
  }
  return cells;
}

std::vector<Cell> polar_cells(const PolarFan& fan, int width, int height) {
  std::vector<Cell> cells;
  cells.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const double from = (fan.min_range_m() - fan.first_range_m) / fan.step_m;
  const double rows = static_cast<double>(fan.samples) - 0.5 - from;
  const double low = fan.min_azimuth_rad(), high = fan.max_azimuth_rad();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double share = (x + 0.5) / width;
      const double column = fan.azimuth_rad.empty() ? static_cast<double>(fan.beams) * share - 0.5
                                                    : fan.column_at(low + (high - low) * share);
      cells.push_back(cell_at(fan, from + rows * (y + 0.5) / height, column));
    }
  }
  return cells;
}

RgbImage paint_values(std::span<const Cell> cells, int width, int height,
                      std::span<const float> values, std::uint64_t columns, const ValueScale& scale,
                      Sampling sampling) {
  RgbImage image(width, height, kWhite);
  const double span = scale.limits[1] - scale.limits[0];
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!cells[i].inside()) continue;
    const float value = sampling == Sampling::bilinear ? bilinear_db(values, columns, cells[i])
                                                       : values[cells[i].nearest(columns)];
    image.set(i, std::isnan(value) ? scale.none
                                   : colour_at(*scale.map, (value - scale.limits[0]) / span));
  }
  return image;
}

RgbImage paint_ids(std::span<const Cell> cells, int width, int height,
                   std::span<const std::uint16_t> ids, std::uint64_t columns) {
  RgbImage image(width, height, kWhite);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].inside()) image.set(i, id_colour(ids[cells[i].nearest(columns)]));
  }
  return image;
}

void outline(RgbImage& image, std::span<const Cell> cells, std::span<const std::uint16_t> ids,
             std::uint64_t columns, int thickness) {
  std::vector<std::uint16_t> shown(cells.size(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].inside()) shown[i] = ids[cells[i].nearest(columns)];
  }
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
           static_cast<std::size_t>(x);
  };
  const int reach = thickness + 1;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!cells[index(x, y)].inside()) continue;
      const std::uint16_t own = shown[index(x, y)];
      std::uint16_t nearest = 0;
      int nearest_distance = reach * reach + 1;
      for (int v = std::max(0, y - reach); v <= std::min(image.height - 1, y + reach); ++v) {
        for (int u = std::max(0, x - reach); u <= std::min(image.width - 1, x + reach); ++u) {
          const std::uint16_t id = shown[index(u, v)];
          const int distance = (u - x) * (u - x) + (v - y) * (v - y);
          if (id == 0 || id == own || distance >= nearest_distance) continue;
          nearest = id;
          nearest_distance = distance;
        }
      }
      if (nearest == 0) continue;
      const bool is_rim = nearest_distance <= thickness * thickness;
      image.set(index(x, y), is_rim ? id_colour(nearest) : kBlack);
    }
  }
}

}  // namespace ensonify
