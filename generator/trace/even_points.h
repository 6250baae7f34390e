// Places of scatterers on even surfaces, so far apart that the expected level just stays even.
//
// Independent places within the leaves of a surface need many leaves for an even level: the noise
// of their density reaches down to the lowest spatial frequencies, where beam and pulse average
// little. The places here come from a pattern of points that repel one another. Its density has no
// noise at frequencies below 0.6 per spacing, and no lattice's peaks above, which would be heard as
// false coherence between pings. The pattern repeats, but no two scatterers share a random
// amplitude.
//
//   EvenSpacing  even_spacing     how far apart places may be
//   EvenPattern  even_pattern     where they are, for a spacing of 1
//   EvenPlane  for_even_points    the same on a plane
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.h"
#include "core/sonar.h"
#include "core/vec.h"
#include "world/shapes.h"

namespace ensonify {

// Rms of the error of the expected level that the places may cause, where their spacing does not
// change. Its steps cause the rest of 0.05 dB.
inline constexpr double kPlacesErrorDb = 0.035;

// Longest spacings by the width of a beam where it meets the surface.
struct EvenSpacing {
  double least_width_m = 0;
  std::vector<double> spacing_m;  // for widths that grow by a factor of sqrt(2); empty: none known

  // Linear between these widths, and that of the nearest one beyond them.
  double at(double width_m) const;
};

// So that the level of a surface that beams and pulse see with any orientation is within
// kPlacesErrorDb. `transform` bins of the pulse's spectrum (Record::transform).
EvenSpacing even_spacing(const Sonar& sonar, const Water& water, int transform);

struct EvenPlace {
  double x = 0, y = 0;  // in [0, kSide)
};

// Repeats in both directions. The places of a cell of 1 x 1 are [first[cell], first[cell + 1]).
struct EvenPattern {
  static constexpr std::int64_t kSide = 32;
  std::array<EvenPlace, kSide * kSide> places;
  std::array<std::uint16_t, kSide * kSide + 1> first;

  std::span<const EvenPlace> cell(std::int64_t x, std::int64_t y) const {
    const auto i = static_cast<std::size_t>(y * kSide + x);
    return std::span(places).subspan(first[i], first[i + 1] - first[i]);
  }
};

const EvenPattern& even_pattern();

// Spacings are discrete, so that neighboring parts of a surface share one: 2^(-scale/4) m.
int even_scale(double spacing_m);
double even_spacing_of(int scale);

// The flat patch of a surface in the coordinates of two axes of its object, those that follow
// `axis` (0: x) cyclically, and the bounds of the patch in them.
struct EvenPlane {
  int axis = 2;
  Vec3 normal;
  // The third coordinate: lift[0] + lift[1] x + lift[2] y.
  std::array<double, 3> lift{};
  std::array<double, 2> low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
  // Of a triangle: a x + b y + c >= 0 inside. A rectangle is what the bounds hold, without the
  // upper ones.
  std::array<std::array<double, 3>, 3> edges{};
  bool is_triangle = false;

  bool contains(double x, double y) const {
    if (!is_triangle) return x >= low[0] && x < high[0] && y >= low[1] && y < high[1];
    for (const auto& [a, b, c] : edges) {
      if (a * x + b * y + c < 0) return false;
    }
    return true;
  }
  Vec3 at(double x, double y) const {
    const double third = lift[0] + lift[1] * x + lift[2] * y;
    if (axis == 0) return {third, x, y};
    return axis == 1 ? Vec3{y, third, x} : Vec3{x, y, third};
  }
  // Area of the patch for one of its projection.
  double stretch() const { return std::hypot(1, lift[1], lift[2]); }
};

// A rectangle along the axes of its object, which gives the axis, and a triangle that does not
// contain the direction of the axis.
EvenPlane even_plane(const RectanglePatch& patch);
EvenPlane even_plane(const TrianglePatch& patch, int axis);

// Where the pattern starts, between 0 and kSide, so that other sequences have other places.
using EvenOrigin = std::array<double, 2>;

namespace even {

// Cells of the pattern: [low, high) in both directions.
struct Cells {
  std::array<std::int64_t, 2> low, high;
  std::int64_t count(int i) const { return high[i] - low[i]; }
};

// Cells that are tested point by point: smaller groups are not worth a test of their ball.
inline constexpr std::int64_t kCellsAtOnce = 64;

inline Cells cells_of(const EvenPlane& plane, double spacing_m, const EvenOrigin& origin) {
  Cells cells{};
  for (int i = 0; i < 2; ++i) {
    cells.low[i] = static_cast<std::int64_t>(std::floor(plane.low[i] / spacing_m - origin[i]));
    cells.high[i] =
        static_cast<std::int64_t>(std::floor(plane.high[i] / spacing_m - origin[i])) + 1;
  }
  return cells;
}

inline Ball ball_of(const EvenPlane& plane, const Cells& cells, double spacing_m,
                    const EvenOrigin& origin) {
  const auto middle = [&](int i) {
    return spacing_m * (static_cast<double>(cells.low[i] + cells.high[i]) / 2 + origin[i]);
  };
  const double wide = static_cast<double>(cells.count(0)),
               high = static_cast<double>(cells.count(1));
  return {plane.at(middle(0), middle(1)),
          spacing_m * std::sqrt(wide * wide + high * high) / 2 * plane.stretch()};
}

// The identity of a place among those of one primitive.
inline std::uint64_t path_of(int scale, std::int64_t x, std::int64_t y, std::size_t place) {
  const std::uint64_t copy =
      std::uint64_t{static_cast<std::uint32_t>(x)} << 32 | static_cast<std::uint32_t>(y);
  return mix64(copy) ^ mix64(~(std::uint64_t{static_cast<std::uint32_t>(scale)} << 32 | place));
}

template <class Visit>
void visit_cell(const EvenPlane& plane, int scale, double spacing_m, const EvenOrigin& origin,
                std::int64_t i, std::int64_t j, const Visit& visit) {
  constexpr std::int64_t kSide = EvenPattern::kSide;
  const EvenPattern& pattern = even_pattern();
  // kSide is a power of two, so this rounds down for negative numbers as well.
  const std::int64_t x = i & (kSide - 1), y = j & (kSide - 1);
  for (const EvenPlace& place : pattern.cell(x, y)) {
    const double at_x = spacing_m * (static_cast<double>(i - x) + place.x + origin[0]);
    const double at_y = spacing_m * (static_cast<double>(j - y) + place.y + origin[1]);
    if (!plane.contains(at_x, at_y)) continue;
    const auto number = static_cast<std::size_t>(&place - pattern.places.data());
    visit(plane.at(at_x, at_y), path_of(scale, (i - x) / kSide, (j - y) / kSide, number));
  }
}

}  // namespace even

// Calls visit(place, path) for the places on a plane, without parts of which part_in(ball) says
// that nothing is heard (FanPart, of surface_points.h).
template <class Part, class PartIn, class Visit>
void for_even_points(const EvenPlane& plane, int scale, const EvenOrigin& origin, Part part,
                     const PartIn& part_in, const Visit& visit) {
  const double spacing_m = even_spacing_of(scale);
  const auto descend = [&](const auto& self, const even::Cells& cells, Part known) -> void {
    if (known == Part::some && cells.count(0) * cells.count(1) > even::kCellsAtOnce) {
      known = part_in(even::ball_of(plane, cells, spacing_m, origin));
    }
    if (known == Part::none) return;
    if (cells.count(0) * cells.count(1) > even::kCellsAtOnce) {
      const int across = cells.count(0) >= cells.count(1) ? 0 : 1;
      even::Cells first = cells, second = cells;
      first.high[across] = second.low[across] = cells.low[across] + cells.count(across) / 2;
      self(self, first, known);
      return self(self, second, known);
    }
    for (std::int64_t j = cells.low[1]; j < cells.high[1]; ++j) {
      for (std::int64_t i = cells.low[0]; i < cells.high[0]; ++i) {
        even::visit_cell(plane, scale, spacing_m, origin, i, j, visit);
      }
    }
  };
  descend(descend, even::cells_of(plane, spacing_m, origin), part);
}

}  // namespace ensonify
