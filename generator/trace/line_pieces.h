// Lines in the world, cut into pieces that are one scatterer each. Private to trace/.
//
//   PlacedWorld   the world at the moment of a ping
//   Line          within_range  pieces_of  piece_middle_m
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/sonar.h"
#include "core/units.h"
#include "trace/cell_cutting.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

struct PlacedWorld {
  const World& world;
  const Tracer& tracer;
  std::span<const Pose> object_in_world;
  const Pose& sonar_in_world;
};

// The ends are middle -+ half.
struct Line {
  Vec3 middle_m, half_m;

  double length_m() const { return 2 * length(half_m); }
};

// Keys leave room for so many. A line of 100 m at 10 MHz has fewer.
inline constexpr int kMostPiecesOfLine = 1 << 26;

// Two-way phase that a straight piece may bend by.
inline constexpr double kLineBend_rad = 0.1;

// The part of a line that is no farther than `range_m` from the eye; none if all of it is farther.
inline std::optional<Line> within_range(const Line& line, Vec3 eye_m, double range_m) {
  const double half = length(line.half_m);
  const Vec3 way = eye_m - line.middle_m;
  if (half == 0) return length(way) <= range_m ? std::optional(line) : std::nullopt;
  const Vec3 along = (1 / half) * line.half_m;
  const double foot = dot(way, along);
  const double beside_squared = std::max(0.0, dot(way, way) - foot * foot);
  if (beside_squared > range_m * range_m) return std::nullopt;
  const double reach = std::sqrt(range_m * range_m - beside_squared);
  const double low = std::max(-half, foot - reach), high = std::min(half, foot + reach);
  if (!(low < high)) return std::nullopt;
  return Line{line.middle_m + ((low + high) / 2) * along, ((high - low) / 2) * along};
}

// How many pieces a line within range is cut into: a piece changes range by at most c/24b, bends by
// kLineBend_rad and is a quarter of the narrowest beam cell long, but not below an eighth of a
// wavelength.
inline int pieces_of(const Line& line, Vec3 eye_m, const Sonar& sonar, const Water& water) {
  const double half = length(line.half_m), c = water.sound_speed_m_s;
  if (half == 0) return 1;
  const double wavelength = c / sonar.frequency_hz;
  const Vec3 way = eye_m - line.middle_m, along = (1 / half) * line.half_m;
  const double foot = std::clamp(dot(way, along), -half, half);
  const double nearest = length(foot * along - way);
  const double longest = std::min({kLongestRange_pulses * c / sonar.bandwidth_hz,
                                   nearest * narrowest_cell_rad(sonar) / 4,
                                   std::sqrt(kLineBend_rad * nearest * wavelength / (kPi / 2))});
  const double count = std::ceil(2 * half / std::max(longest, wavelength / 8));
  return static_cast<int>(std::min(count, double(kMostPiecesOfLine)));
}

inline Vec3 piece_middle_m(const Line& line, int piece, int count) {
  return line.middle_m + ((2 * piece + 1.0) / count - 1) * line.half_m;
}

}  // namespace ensonify
