// Lines in the world, cut into pieces that are one scatterer each. Private to trace/.
//
//   PlacedWorld   the world at the moment of a ping
//   Line          line_between  pieces_of  piece_middle_m
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "core/sonar.h"
#include "core/units.h"
#include "trace/tracer.h"
#include "trace/cell_cutting.h"
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

// Two-way phase that a straight piece may bend by.
inline constexpr double kLineBend_rad = 0.1;

// How many pieces a line is cut into: a piece changes range by at most c/24b, bends by
// kLineBend_rad and is a quarter of a beam cell long. 0: it lies beyond the range.
inline int pieces_of(const Line& line, Vec3 eye_m, const Sonar& sonar, const Water& water) {
  const double half = length(line.half_m), c = water.sound_speed_m_s;
  if (half == 0) return 1;
  const double wavelength = c / sonar.frequency_hz;
  const Vec3 way = eye_m - line.middle_m, along = (1 / half) * line.half_m;
  const double foot = std::clamp(dot(way, along), -half, half);
  const double nearest = length(foot * along - way);
  if (nearest > sonar.range_max_m) return 0;
  const double longest = std::min({kLongestRange_pulses * c / sonar.bandwidth_hz,
                                   nearest * sonar.beam_spacing_rad / 4,
                                   std::sqrt(kLineBend_rad * nearest * wavelength / (kPi / 2))});
  return static_cast<int>(std::ceil(2 * half / std::max(longest, wavelength / 8)));
}

inline Vec3 piece_middle_m(const Line& line, int piece, int count) {
  return line.middle_m + ((2 * piece + 1.0) / count - 1) * line.half_m;
}

}  // namespace ensonify
