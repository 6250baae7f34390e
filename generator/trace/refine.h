// From what Embree says back to double precision.
//
//   Found  refine              of the nearest surface of all
//   refine_on_mesh  hit_of  plane_hit   of one object
#pragma once

#include <optional>

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

// The hits of those rays whose `found` is of the mesh at geometry `instance`; others stay.
void refine_on_mesh(const Scene& scene, const Query& query, std::span<const Found> found,
                    unsigned instance, Hit* hits);

// Of a closed form that was met in its own frame.
Hit hit_of(const SurfaceHit& surface, Vec3 local_direction, const PlacedObject& placed);

// Of the scene's plane of that number; none where the ray does not meet it.
std::optional<Hit> plane_hit(const Scene& scene, const Query& query, unsigned ray,
                             std::size_t plane);

}  // namespace ensonify
