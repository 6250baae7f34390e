#include "figure/paint.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr Rgb kBlack{};

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
