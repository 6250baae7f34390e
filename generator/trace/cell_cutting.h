// Cells of the fan cut into parts over which the range is nearly linear, for coherent sums. Private
// to trace/.
//
//   CellPart  cell_of     a cell or a part of one, with the hits of nine rays through it
//   Bend  bend_of         the range over a part, by finite differences
//   bend_factor           the first-order effect of the bend on the sum over a part
//   divide                cuts a cell until each part is nearly linear, and passes on each part
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "acoustics/pattern.h"
#include "core/units.h"

namespace ensonify {

// Largest phase of the bend of a part, in addition to the linear phase. The amplitude includes the
// bend to first order, which leaves an error of 0.02 rad.
inline constexpr double kBend_rad = 0.2;
// The smallest sides of parts that are cut for their phase or for an edge. An edge along a side of
// its parts causes the same error in all of them, so such parts are cut further.
inline constexpr double kSmallestSide_wavelengths = 0.25;
inline constexpr double kSmallestEdge_wavelengths = 1.0 / 8;
inline constexpr double kSmallestStraightEdge_wavelengths = 1.0 / 32;
// Longest extent of a part in range, in units of c/b. A part has one delay and the sinc at the
// carrier; longer parts leave echoes in the middle of an oblique plate.
inline constexpr double kLongestRange_pulses = 1.0 / 24;

// A cell of the fan or a part of one, with the hits of rays through its corners, the middles of its
// sides and its middle. A Sample has range_m and the functions
//   same_body(a, b)     whether their ranges may be compared
//   same_surface(a, b)  whether no edge lies between them
template <class Sample>
struct CellPart {
  std::array<double, 3> azimuth_rad{}, elevation_rad{};  // low, middle, high
  std::array<std::array<Sample, 3>, 3> hits;             // [azimuth][elevation]
};

// The range over a part: its linear change with the angles, and the deviations from it.
struct Bend {
  double change_azimuth_m = 0, change_elevation_m = 0;  // across the part
  double azimuth_m = 0, elevation_m = 0;                // at the middles of the sides
  double twist_m = 0;   // at the corners, from the product of both angles
  double corner_m = 0;  // largest total deviation at a corner
};

// The change of range across the part, from those sides that lie on the surface of the middle.
template <class Sample>
double change_across(const Sample& low, const Sample& middle, const Sample& high) {
  const bool below = same_body(low, middle), above = same_body(high, middle);
  if (below && above) return high.range_m - low.range_m;
  if (above) return 2 * (high.range_m - middle.range_m);
  return below ? 2 * (middle.range_m - low.range_m) : 0;
}

// Uses only the hits on the surface of the middle; deviations at other hits count as 0.
template <class Sample>
Bend bend_of(const CellPart<Sample>& part) {
  const auto& hits = part.hits;
  const Sample& middle = hits[1][1];
  const auto same = [&](int a, int e) { return same_body(hits[a][e], middle); };
  const auto range = [&](int a, int e) { return hits[a][e].range_m; };
  Bend bend;
  bend.change_azimuth_m = change_across(hits[0][1], middle, hits[2][1]);
  bend.change_elevation_m = change_across(hits[1][0], middle, hits[1][2]);
  if (same(0, 1) && same(2, 1)) bend.azimuth_m = (range(0, 1) + range(2, 1)) / 2 - middle.range_m;
  if (same(1, 0) && same(1, 2)) {
    bend.elevation_m = (range(1, 0) + range(1, 2)) / 2 - middle.range_m;
  }
  if (same(0, 0) && same(0, 2) && same(2, 0) && same(2, 2)) {
    bend.twist_m = (range(0, 0) + range(2, 2) - range(0, 2) - range(2, 0)) / 4;
  }
  for (const int a : {0, 2}) {
    for (const int e : {0, 2}) {
      if (!same(a, e)) continue;
      const double linear =
          middle.range_m +
          ((a - 1) * bend.change_azimuth_m + (e - 1) * bend.change_elevation_m) / 2;
      bend.corner_m = std::max(bend.corner_m, std::abs(range(a, e) - linear));
    }
  }
  return bend;
}

// The mean of x e^(-i g x) divided by i, and the mean of x^2 e^(-i g x), over x in [-1, 1]. For |g|
// below 1e-2 the quotients would lose digits, while the series are exact to 1e-9.
inline double first_moment(double g) {
  if (std::abs(g) < 1e-2) return -g / 3 * (1 - g * g / 10);
  return (std::cos(g) - std::sin(g) / g) / g;
}
inline double second_moment(double g) {
  if (std::abs(g) < 1e-2) return 1.0 / 3 - g * g / 10;
  return std::sin(g) / g + 2 * (std::cos(g) - std::sin(g) / g) / (g * g);
}

// The first-order effect of the bend, which is added to sinc . sinc: the mean over the part of
// -i 2k (azimuth x^2 + elevation y^2 + twist x y) e^(-i (g_x x + g_y y)), x and y in [-1, 1].
inline std::complex<double> bend_factor(const Bend& bend, double wavelength_m) {
  const double two_k = 4 * kPi / wavelength_m;
  const double gx = two_k * bend.change_azimuth_m / 2, gy = two_k * bend.change_elevation_m / 2;
  // The bend is larger than this only at limbs and creases, where the first order is not valid.
  const auto phase = [&](double range_m) {
    return std::clamp(two_k * range_m, -kBend_rad, kBend_rad);
  };
  const double sum = phase(bend.azimuth_m) * second_moment(gx) * sinc(gy / kPi) +
                     phase(bend.elevation_m) * second_moment(gy) * sinc(gx / kPi) -
                     phase(bend.twist_m) * first_moment(gx) * first_moment(gy);
  return {0, -sum};
}

enum class Cut { none, across_azimuth, across_elevation };

struct CutWish {
  bool azimuth = false, elevation = false;
};

// Asks for cuts if an edge runs between neighboring rays of the part.
template <class Sample>
CutWish cuts_for_edges(const CellPart<Sample>& part) {
  CutWish want;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 2; ++k) {
      want.azimuth |= !same_surface(part.hits[k][i], part.hits[k + 1][i]);
      want.elevation |= !same_surface(part.hits[i][k], part.hits[i][k + 1]);
    }
  }
  return want;
}

// Asks for cuts if the range bends or changes too much for one scatterer.
template <class Sample, class Aim>
CutWish cuts_for_phase(const CellPart<Sample>& part, const Aim& aim) {
  const Bend bend = bend_of(part);
  CutWish want{std::abs(bend.change_azimuth_m) > aim.range_limit_m,
               std::abs(bend.change_elevation_m) > aim.range_limit_m};
  const double in_azimuth = std::abs(bend.azimuth_m), in_elevation = std::abs(bend.elevation_m);
  const double worst = std::max({in_azimuth, in_elevation, bend.corner_m});
  if (4 * kPi / aim.wavelength_m * worst <= kBend_rad) return want;
  // The part of a corner's bend that the sides do not explain is a twist, which either cut reduces.
  const double twist = std::max(0.0, bend.corner_m - in_azimuth - in_elevation);
  want.azimuth |= in_azimuth + twist >= (in_elevation + twist) / 2;
  want.elevation |= in_elevation + twist >= (in_azimuth + twist) / 2;
  return want;
}

// The side to cut, the longer one if both need it; none if the part needs no cut.
template <class Sample, class Aim>
Cut cut_of(const CellPart<Sample>& part, const Aim& aim) {
  double range = 0;
  for (const auto& column : part.hits) {
    for (const Sample& hit : column) range = std::max(range, hit.range_m);
  }
  const double width =
      range * std::cos(part.elevation_rad[1]) * (part.azimuth_rad[2] - part.azimuth_rad[0]);
  const double height = range * (part.elevation_rad[2] - part.elevation_rad[0]);
  const auto allowed = [&](CutWish want, double smallest_wavelengths) {
    const double smallest = smallest_wavelengths * aim.wavelength_m;
    return CutWish{want.azimuth && width > smallest, want.elevation && height > smallest};
  };
  const CutWish edge = cuts_for_edges(part);
  const bool straight = edge.azimuth != edge.elevation;
  CutWish want =
      allowed(edge, straight ? kSmallestStraightEdge_wavelengths : kSmallestEdge_wavelengths);
  if (aim.is_mirror(part.hits[1][1])) {
    const CutWish phase = allowed(cuts_for_phase(part, aim), kSmallestSide_wavelengths);
    want = {want.azimuth || phase.azimuth, want.elevation || phase.elevation};
  }
  if (want.azimuth && (!want.elevation || width >= height)) return Cut::across_azimuth;
  return want.elevation ? Cut::across_elevation : Cut::none;
}

// One half of a part: 0 low, 1 high.
template <class Sample, class Aim>
CellPart<Sample> half_of(const CellPart<Sample>& part, Cut cut, int half, const Aim& aim) {
  const bool in_azimuth = cut == Cut::across_azimuth;
  CellPart<Sample> result = part;
  auto& angle = in_azimuth ? result.azimuth_rad : result.elevation_rad;
  const double low = angle[half], high = angle[half + 1];
  angle = {low, (low + high) / 2, high};
  for (int i = 0; i < 3; ++i) {
    const auto hit = [&](CellPart<Sample>& p, int k) -> Sample& {
      return in_azimuth ? p.hits[k][i] : p.hits[i][k];
    };
    // Copies both outer samples first, because they come from the parent and one of them keeps its
    // place.
    const Sample first = hit(result, half), last = hit(result, half + 1);
    hit(result, 0) = first;
    hit(result, 2) = last;
    hit(result, 1) = in_azimuth ? aim.shoot(angle[1], part.elevation_rad[i])
                                : aim.shoot(part.azimuth_rad[i], angle[1]);
  }
  return result;
}

// Cuts a cell and passes each part in which a ray met a smooth surface to aim.add. An Aim has
// wavelength_m, range_limit_m (longest extent of a part in range), shoot(azimuth, elevation),
// is_mirror(sample) and add(part).
template <class Sample, class Aim>
void divide(const CellPart<Sample>& part, Aim& aim) {
  const bool any = std::any_of(part.hits.begin(), part.hits.end(), [&](const auto& column) {
    return std::any_of(column.begin(), column.end(),
                       [&](const Sample& hit) { return aim.is_mirror(hit); });
  });
  if (!any) return;
  const Cut cut = cut_of(part, aim);
  if (cut == Cut::none) return aim.add(part);
  for (const int half : {0, 1}) divide(half_of(part, cut, half, aim), aim);
}

template <class Sample, class Aim>
CellPart<Sample> cell_of(double azimuth_rad, double azimuth_step_rad, double elevation_rad,
                         double elevation_step_rad, const Aim& aim) {
  CellPart<Sample> part;
  for (int i = 0; i < 3; ++i) {
    part.azimuth_rad[i] = azimuth_rad + (i - 1) * azimuth_step_rad / 2;
    part.elevation_rad[i] = elevation_rad + (i - 1) * elevation_step_rad / 2;
  }
  for (int a = 0; a < 3; ++a) {
    for (int e = 0; e < 3; ++e) {
      part.hits[a][e] = aim.shoot(part.azimuth_rad[a], part.elevation_rad[e]);
    }
  }
  return part;
}

}  // namespace ensonify
