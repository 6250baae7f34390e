#include "labels/cartesian.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace ensonify {
namespace {

template <class T>
std::vector<T> gather(const std::vector<T>& source, const std::vector<std::int32_t>& map,
                      T outside) {
  std::vector<T> result(map.size(), outside);
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) result[i] = source[map[i]];
  }
  return result;
}

}  // namespace

CartesianGrid cartesian_grid(const Sonar& sonar, int height_px) {
  const double half_fan = sonar.beam_count * sonar.beam_spacing_rad / 2;
  const double reach = sonar.range_max_m;
  const double bottom = std::min(0.0, reach * std::cos(half_fan));
  const double side = reach * std::sin(std::min(half_fan, kPi / 2));
  CartesianGrid grid;
  grid.height_px = height_px;
  grid.m_per_px = (reach - bottom) / height_px;
  // The small slack keeps a width that is whole up to rounding from growing by a column.
  grid.width_px = std::max(1, static_cast<int>(std::ceil(2 * side / grid.m_per_px - 1e-9)));
  grid.x_top_m = reach;
  grid.y_left_m = grid.width_px * grid.m_per_px / 2;
  return grid;
}

std::vector<std::int32_t> cartesian_map(const CartesianGrid& grid, const Sonar& sonar,
                                        const Water& water, const Record& record) {
  std::vector<std::int32_t> map(std::size_t(grid.height_px) * grid.width_px, -1);
  const double samples_per_m = 2.0 * sonar.bandwidth_hz / water.sound_speed_m_s;
  for (int row = 0; row < grid.height_px; ++row) {
    const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
    for (int column = 0; column < grid.width_px; ++column) {
      const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
      const std::optional<int> beam = sector_of(sonar, std::atan2(y, x));
      const long sample = std::lround(std::hypot(x, y) * samples_per_m);
      if (!beam || sample >= record.samples) continue;
      map[std::size_t(row) * grid.width_px + column] =
          static_cast<std::int32_t>(sample * sonar.beam_count + *beam);
    }
  }
  return map;
}

LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  LabelledImage image;
  image.rows = grid.height_px;
  image.columns = grid.width_px;
  image.level_db = gather(polar.level_db, map, kNoEnergyDb);
  image.clean_db = gather(polar.clean_db, map, kNoEnergyDb);
  image.elevation_rad = gather(polar.elevation_rad, map, nan);
  image.elevation_std_rad = gather(polar.elevation_std_rad, map, nan);
  image.instance_fraction = gather(polar.instance_fraction, map, 0.0f);
  image.instance = gather(polar.instance, map, std::uint16_t{0});
  image.semantic = gather(polar.semantic, map, std::uint8_t{0});
  return image;
}

}  // namespace ensonify
