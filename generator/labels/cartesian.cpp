#include "labels/cartesian.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/error.h"
#include "core/image_planes.h"
#include "core/units.h"
#include "labels/look_up.h"

namespace ensonify {
namespace {

// Planes that are only there when asked for may be empty.
void check_sizes(const LabelledImage& image) {
  const auto pixels =
      static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
  for (const ImagePlane& plane : kImagePlanes) {
    const std::size_t size = with_plane(image, plane, [](const auto& v) { return v.size(); });
    ENSONIFY_ASSERT(size == pixels || (size == 0 && plane.wanted != nullptr));
  }
}

// Far under a pixel, far over what rounding does.
constexpr double kSlack = 1e-9;

// Of the sectors' borders; what is not ahead is infinitely far to its side.
std::vector<double> edge_tangents(const Sonar& sonar) {
  std::vector<double> edges;
  for (int k = 0; k <= sonar.beam_count; ++k) {
    const double azimuth = (k - sonar.beam_count / 2.0) * sonar.beam_spacing_rad;
    const bool ahead = std::abs(azimuth) < kPi / 2;
    edges.push_back(ahead ? std::tan(azimuth)
                          : std::copysign(std::numeric_limits<double>::infinity(), azimuth));
  }
  return edges;
}

// What sector_of says of atan2(y, x), for y that fall along a row. The arc tangent took two thirds
// of a map's time: only pixels on a border, or not ahead, need it.
class SectorsOfRow {
 public:
  SectorsOfRow(const Sonar& sonar, std::span<const double> edges, double x)
      : sonar_(sonar), edges_(edges), x_(x), beam_(sonar.beam_count) {}

  // -1 outside the fan.
  int at(double y) {
    if (!(x_ > 0)) return exactly(y);
    const double tangent = y / x_, slack = kSlack * (1 + tangent * tangent);
    while (beam_ >= 0 && tangent < edges_[beam_]) --beam_;
    if (beam_ >= 0 && tangent - edges_[beam_] < slack) return exactly(y);
    if (beam_ < sonar_.beam_count && edges_[beam_ + 1] - tangent < slack) return exactly(y);
    return beam_ < sonar_.beam_count ? beam_ : -1;
  }

 private:
  int exactly(double y) const { return sector_of(sonar_, std::atan2(y, x_)).value_or(-1); }

  const Sonar& sonar_;
  std::span<const double> edges_;
  double x_;
  int beam_;  // edges_[beam_] <= tangent < edges_[beam_ + 1]
};

// That of hypot, which is needed half way between two samples alone.
long nearest_sample(double x, double y, double samples_per_m) {
  const double at = std::sqrt(x * x + y * y) * samples_per_m, below = std::floor(at);
  if (std::abs(at - below - 0.5) < kSlack * at) {
    return std::lround(std::hypot(x, y) * samples_per_m);
  }
  return static_cast<long>(below) + (at - below > 0.5);
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
  const std::vector<double> edges = edge_tangents(sonar);
  for (int row = 0; row < grid.height_px; ++row) {
    const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
    SectorsOfRow sectors(sonar, edges, x);
    for (int column = 0; column < grid.width_px; ++column) {
      const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
      const int beam = sectors.at(y);
      if (beam < 0) continue;
      const long sample = nearest_sample(x, y, samples_per_m);
      if (sample >= record.samples) continue;
      map[std::size_t(row) * grid.width_px + column] =
          static_cast<std::int32_t>(sample * sonar.beam_count + beam);
    }
  }
  return map;
}

ENSONIFY_VECTOR_CLONES void look_up(const float* polar, const std::int32_t* map, std::size_t count,
                                    float blank, float* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = map[i] >= 0 ? polar[map[i]] : blank;
}

LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map, ResampledPlanes planes) {
  check_sizes(polar);
  LabelledImage image;
  image.rows = grid.height_px;
  image.columns = grid.width_px;
  for (const ImagePlane& plane : kImagePlanes) {
    if (planes == ResampledPlanes::ids && is_float_plane(plane)) continue;
    std::visit(
        [&](auto member) {
          using Value = typename std::decay_t<decltype(image.*member)>::value_type;
          const auto& from = polar.*member;
          if (from.empty()) return;
          image.*member = looked_up(from, blank_value<Value>(plane.blank), grid, map);
        },
        plane.values);
  }
  return image;
}

GreyImage resample(const GreyImage& polar, const CartesianGrid& grid,
                   const std::vector<std::int32_t>& map) {
  return {grid.height_px, grid.width_px, looked_up(polar.pixels, std::uint8_t{0}, grid, map)};
}

std::vector<double> shown_gain_db(const GreySettings& settings, double absorption_db_m,
                                  double step_m, int samples) {
  std::vector<double> gain_db;
  for (int n = 0; n < samples; ++n) {
    const double range_m = std::max(n, 1) * step_m;
    const double absorbed_db = settings.absorption ? 2 * absorption_db_m * range_m : 0;
    gain_db.push_back(settings.gain_db + settings.spreading * std::log10(range_m) + absorbed_db);
  }
  return gain_db;
}

std::vector<float> with_gain(std::span<const float> level_db, std::span<const double> gain_db) {
  std::vector<float> shown(level_db.begin(), level_db.end());
  const std::size_t columns = level_db.size() / gain_db.size();
  for (std::size_t n = 0; n < gain_db.size(); ++n) {
    for (float& level : std::span(shown).subspan(n * columns, columns)) {
      if (level > kNoEnergyDb) level = static_cast<float>(level + gain_db[n]);
    }
  }
  return shown;
}

GreyImage grey_image(int rows, int columns, std::span<const float> level_db, GreyScale scale,
                     const std::array<double, 2>& db_limits) {
  GreyImage grey{rows, columns, {}};
  grey.pixels.resize(level_db.size());
  const double black = db_limits[0], white = db_limits[1];
  const double slope = 255.0 / (white - black);
  const float* level = level_db.data();
  std::uint8_t* pixel = grey.pixels.data();
  const auto fill = [&](auto value_of) {
    for (std::size_t i = 0, count = grey.pixels.size(); i < count; ++i) {
      const double heard = level[i] > kNoEnergyDb ? value_of(level[i]) : 0.0;
      const double value = std::min(std::max(0.0, heard), 255.0);
      pixel[i] = static_cast<std::uint8_t>(static_cast<int>(value + 0.5));
    }
  };
  if (scale == GreyScale::db) {
    fill([=](float db) { return (db - black) * slope; });
  } else {
    fill([=](float db) { return 255 * std::pow(10.0, (db - white) / 20); });
  }
  return grey;
}

std::array<double, 2> db_limits_from_clean(std::span<const float> clean_db,
                                           std::span<const float> elevation_rad) {
  std::vector<float> levels;
  for (std::size_t i = 0; i < clean_db.size(); ++i) {
    if (!std::isnan(elevation_rad[i]) && clean_db[i] > kNoEnergyDb) {
      levels.push_back(clean_db[i]);
    }
  }
  if (levels.empty()) return {60, 120};
  const auto percentile = [&](double p) {
    const auto nth = levels.begin() + static_cast<std::ptrdiff_t>(p * (levels.size() - 1));
    std::nth_element(levels.begin(), nth, levels.end());
    return *nth;
  };
  const double white = std::ceil(percentile(0.99) + 6.0);
  const double black = std::floor(percentile(0.05) - 10.0);
  return {std::clamp(black, white - 80.0, white - 40.0), white};
}

}  // namespace ensonify
