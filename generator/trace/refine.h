// From what Embree says back to double precision.
#pragma once

#include <span>

#include "trace/scene.h"

namespace ensonify {

// What Embree says of one ray.
struct Found {
  unsigned geometry = RTC_INVALID_GEOMETRY_ID;  // none: it met nothing
  unsigned instance = RTC_INVALID_GEOMETRY_ID;  // of a mesh: its geometry in the top scene
  unsigned triangle = 0;
  float range_m = 0;
  float u = 0, v = 0;
};

// Range and incidence of the query's rays, one a `found`, in double. Planes, of which Embree knows
// nothing, are looked at here. A ray's hit does not depend on what goes with it.
void refine(const Scene& scene, const Query& query, std::span<const Found> found,
            double range_max_m, Hit* hits);

}  // namespace ensonify
