#include "labels/cartesian.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/image_planes.h"
#include "core/units.h"
#include "labels/shadow.h"

namespace ensonify {
namespace {

// Neighboring pixels of a row lie far apart in the polar image, whose rows they cross. A tile needs
// no more polar rows than the processor's cache holds.
constexpr int kTile_px = 64;
struct Tile {
  int first_row = 0, end_row = 0, first_column = 0, end_column = 0;
};

struct Pixel {
  std::int32_t to = 0, from = 0;
};

// Levels are everywhere in the fan. All other planes are mostly blank.
bool is_everywhere(const ImagePlane& plane) { return plane.blank == PlaneBlank::no_energy; }

// Calls use(from, to, plane, blank value) for those planes in `planes` that the polar image has.
template <class Use>
void for_each_plane(ResampledPlanes planes, const LabelledImage& from, LabelledImage& to, Use use) {
  for (const ImagePlane& plane : kImagePlanes) {
    if (planes == ResampledPlanes::ids && is_float_plane(plane)) continue;
    std::visit(
        [&](auto member) {
          using Value = typename std::decay_t<decltype(to.*member)>::value_type;
          if ((from.*member).empty()) return;
          use(from.*member, to.*member, plane, blank_value<Value>(plane.blank));
        },
        plane.values);
  }
}

// Optional planes may be empty.
void check_sizes(const LabelledImage& image) {
  const auto pixels =
      static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
  for (const ImagePlane& plane : kImagePlanes) {
    const std::size_t size = with_plane(image, plane, [](const auto& v) { return v.size(); });
    ENSONIFY_ASSERT(size == pixels || (size == 0 && plane.wanted != nullptr));
  }
}

template <class Value>
bool is_blank(Value value, Value blank) {
  if constexpr (std::is_floating_point_v<Value>) {
    if (std::isnan(blank)) return std::isnan(value);
  }
  return value == blank;
}

template <class Value>
void mark(const std::vector<Value>& values, Value blank, std::vector<std::uint8_t>& marks) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    marks[i + 1] = static_cast<std::uint8_t>(marks[i + 1] | !is_blank(values[i], blank));
  }
}

// Which polar pixels hold anything besides levels, from [1] on. Most hold nothing, and bytes are
// read faster than all planes.
std::vector<std::uint8_t> marks_of(const LabelledImage& polar, ResampledPlanes planes,
                                   const InstanceSets* sets, LabelledImage& image) {
  std::vector<std::uint8_t> marks(std::size_t(polar.rows) * polar.columns + 1);
  for_each_plane(planes, polar, image,
                 [&](const auto& from, auto&, const ImagePlane& plane, auto blank) {
                   if (!is_everywhere(plane)) mark(from, blank, marks);
                 });
  if (sets != nullptr) mark(sets->set, 0u, marks);
  return marks;
}

// The pixels of a tile that lie in the fan and, if there are marks, on one.
void list_pixels(const std::vector<std::int32_t>& map, int columns, const Tile& tile,
                 const std::uint8_t* marks, std::vector<Pixel>& pixels) {
  pixels.resize(kTile_px * kTile_px);
  std::size_t count = 0;
  for (int row = tile.first_row; row < tile.end_row; ++row) {
    for (int column = tile.first_column; column < tile.end_column; ++column) {
      const int to = row * columns + column;
      pixels[count] = {to, map[to]};
      count += marks != nullptr ? marks[map[to] + 1] : map[to] >= 0;
    }
  }
  pixels.resize(count);
}

template <class T>
void copy_pixels(std::span<const Pixel> pixels, const std::vector<T>& from, std::vector<T>& to) {
  for (const Pixel& pixel : pixels) to[pixel.to] = from[pixel.from];
}

// Much smaller than a pixel and much larger than rounding errors.
constexpr double kSlack = 1e-9;

// The tangents of the borders of beam cells. A border that is not ahead of the sonar has an
// infinite tangent with the sign of its side.
std::vector<double> edge_tangents(const Sonar& sonar) {
  std::vector<double> edges;
  for (const double azimuth : beam_borders_rad(sonar)) {
    const bool ahead = std::abs(azimuth) < kPi / 2;
    edges.push_back(ahead ? std::tan(azimuth)
                          : std::copysign(std::numeric_limits<double>::infinity(), azimuth));
  }
  return edges;
}

// sector_of(atan2(y, x)) for falling y along a row, by comparing tangents. The arc tangent would
// take two thirds of a map's time; only pixels on a border or not ahead of the sonar need it.
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

// The columns of a row that may have pixels in the fan and within `reach_m`, and few others.
struct Columns {
  int begin = 0, end = 0;
};
Columns columns_of_row(const CartesianGrid& grid, std::span<const double> edges, double reach_m,
                       double x) {
  double left = std::sqrt(std::max(reach_m * reach_m - x * x, 0.0)), right = -left;
  if (x > 0) {
    left = std::min(left, x * edges.back());
    right = std::max(right, x * edges.front());
  }
  const auto column = [&](double y) {
    const double place = (grid.y_left_m - y) / grid.m_per_px;
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(grid.width_px)));
  };
  const double slack_m = 2 * grid.m_per_px;
  return {column(left + slack_m), column(right - slack_m)};
}

// In samples after the first, `first` samples from the sonar.
ENSONIFY_VECTOR_CLONES void places_of_row(const CartesianGrid& grid, const Columns& columns,
                                          double x, double samples_per_m, double first,
                                          double* __restrict places) {
  for (int column = columns.begin; column < columns.end; ++column) {
    const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
    places[column] = std::sqrt(x * x + y * y) * samples_per_m - first;
  }
}

// The sample nearest to the result of hypot, which is needed only halfway between two samples.
// `at`: of places_of_row.
long nearest_sample(double at, double x, double y, double samples_per_m, double first) {
  // Rounded down as std::floor does, which is a call of a library.
  const double toward_zero = static_cast<double>(static_cast<long>(at));
  const double below = toward_zero - (toward_zero > at);
  if (std::abs(at - below - 0.5) < kSlack * (at + first)) {
    return std::lround(std::hypot(x, y) * samples_per_m - first);
  }
  return static_cast<long>(below) + (at - below > 0.5);
}

}  // namespace

CartesianGrid cartesian_grid(const Sonar& sonar, int height_px) {
  const double half_fan = furthest_azimuth_rad(sonar);
  const double reach = sonar.range_max_m;
  const double bottom = std::min(0.0, reach * std::cos(half_fan));
  const double side = reach * std::sin(std::min(half_fan, kPi / 2));
  CartesianGrid grid;
  grid.height_px = height_px;
  grid.m_per_px = (reach - bottom) / height_px;
  // The slack keeps rounding from adding a column to an integer width.
  grid.width_px = std::max(1, static_cast<int>(std::ceil(2 * side / grid.m_per_px - 1e-9)));
  grid.x_top_m = reach;
  grid.y_left_m = grid.width_px * grid.m_per_px / 2;
  return grid;
}

std::vector<std::int32_t> cartesian_map(const CartesianGrid& grid, const Sonar& sonar,
                                        const Water& water, const Record& record) {
  std::vector<std::int32_t> map(std::size_t(grid.height_px) * grid.width_px, -1);
  const double samples_per_m = 2.0 * sonar.bandwidth_hz / water.sound_speed_m_s;
  const double first = sonar.first_range_m * samples_per_m;
  const std::vector<double> edges = edge_tangents(sonar);
  const double reach_m = (first + record.samples) / samples_per_m;
  std::vector<double> places(static_cast<std::size_t>(grid.width_px));
  for (int row = 0; row < grid.height_px; ++row) {
    const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
    const Columns columns = columns_of_row(grid, edges, reach_m, x);
    places_of_row(grid, columns, x, samples_per_m, first, places.data());
    SectorsOfRow sectors(sonar, edges, x);
    for (int column = columns.begin; column < columns.end; ++column) {
      const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
      const int beam = sectors.at(y);
      if (beam < 0) continue;
      const long sample = nearest_sample(places[column], x, y, samples_per_m, first);
      if (sample < 0 || sample >= record.samples) continue;
      map[std::size_t(row) * grid.width_px + column] =
          static_cast<std::int32_t>(sample * sonar.beam_count + beam);
    }
  }
  return map;
}

LabelledImage resample(const LabelledImage& polar, const CartesianGrid& grid,
                       const std::vector<std::int32_t>& map, ResampledPlanes planes,
                       InstanceSets* sets) {
  check_sizes(polar);
  LabelledImage image;
  image.rows = grid.height_px;
  image.columns = grid.width_px;
  const std::vector<std::uint8_t> marks = marks_of(polar, planes, sets, image);
  std::vector<std::uint32_t> set;
  if (sets != nullptr) set.reserve(map.size());
  for_each_plane(planes, polar, image,
                 [&](const auto&, auto& to, auto&&...) { to.reserve(map.size()); });
  std::vector<Pixel> pixels;
  for (int row = 0; row < grid.height_px; row += kTile_px) {
    const int end_row = std::min(row + kTile_px, grid.height_px);
    const std::size_t end = std::size_t(end_row) * grid.width_px;
    for_each_plane(planes, polar, image, [&](const auto&, auto& to, const ImagePlane&, auto blank) {
      to.resize(end, blank);
    });
    if (sets != nullptr) set.resize(end);
    for (int column = 0; column < grid.width_px; column += kTile_px) {
      const Tile tile{row, end_row, column, std::min(column + kTile_px, grid.width_px)};
      const auto copy = [&](bool everywhere) {
        list_pixels(map, grid.width_px, tile, everywhere ? nullptr : marks.data(), pixels);
        for_each_plane(planes, polar, image,
                       [&](const auto& from, auto& to, const ImagePlane& plane, auto) {
                         if (is_everywhere(plane) == everywhere) copy_pixels(pixels, from, to);
                       });
      };
      if (planes == ResampledPlanes::all) copy(true);
      copy(false);
      if (sets != nullptr) copy_pixels(pixels, sets->set, set);
    }
  }
  if (sets != nullptr) {
    sets->rows = grid.height_px;
    sets->columns = grid.width_px;
    sets->set = std::move(set);
  }
  return image;
}

GreyImage resample(const GreyImage& polar, const CartesianGrid& grid,
                   const std::vector<std::int32_t>& map) {
  GreyImage grey{grid.height_px, grid.width_px, std::vector<std::uint8_t>(map.size())};
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) grey.pixels[i] = polar.pixels[static_cast<std::size_t>(map[i])];
  }
  return grey;
}

}  // namespace ensonify
