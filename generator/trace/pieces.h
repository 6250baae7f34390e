// Straight pieces of paths between surfaces. Private to trace/.
//
//   kOnMirror_m  hit_after
#pragma once

#include <algorithm>

#include "trace/tracer.h"

namespace ensonify {

// A hit nearer than this to the surface on which a piece starts is that surface itself.
inline constexpr double kOnMirror_m = 1e-4;

// The first hit of a piece. If it starts on a surface, that surface does not count.
inline Hit hit_after(const Tracer& tracer, Vec3 from_m, Vec3 direction, double range_max_m,
                     bool on_surface) {
  Hit hit = tracer.first_hit({from_m, direction}, range_max_m);
  if (!on_surface || hit.instance == 0 || hit.range_m > kOnMirror_m) return hit;
  hit = tracer.first_hit({from_m + kOnMirror_m * direction, direction},
                         std::max(0.0, range_max_m - kOnMirror_m));
  hit.range_m += kOnMirror_m;
  return hit;
}

}  // namespace ensonify
