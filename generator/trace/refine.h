// Embree's results in double precision. Private to trace/.
//
//   Found  refine                        of the nearest surface of all
//   refine_on_mesh  hit_of  plane_hit    of one object
//   apply_fields                         factors and patches of uneven surfaces
//   color_of                             of the mesh's vertices
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "trace/scene.h"

namespace ensonify {

// Embree's result for one ray.
struct Found {
  unsigned geometry = RTC_INVALID_GEOMETRY_ID;  // invalid: the ray met nothing
  unsigned instance = RTC_INVALID_GEOMETRY_ID;  // of a mesh: its geometry in the top scene
  unsigned triangle = 0;
  float range_m = 0;
  float u = 0, v = 0;
};

// The hits of the query's rays, one for each `found`, in double precision. Planes, which Embree
// does not hold, are tested here. The hit of a ray does not depend on the other rays.
void refine(const Scene& scene, const Query& query, std::span<const Found> found,
            double range_max_m, Hit* hits);

// The hits of those rays whose `found` is on the mesh at geometry `instance`; others do not change.
void refine_on_mesh(const Scene& scene, const Query& query, std::span<const Found> found,
                    unsigned instance, Hit* hits);

// The hit on a closed form, from one in its own frame.
Hit hit_of(const SurfaceHit& surface, Vec3 local_direction, const PlacedObject& placed);

// The hit on one of the scene's planes, by number; none if the ray does not meet it.
std::optional<Hit> plane_hit(const Scene& scene, const Query& query, unsigned ray,
                             std::size_t plane);

// Factors and patches of uneven surfaces, by the place of the hit in its object's frame.
void apply_fields(const Scene& scene, const Ray& ray, std::span<Hit> hits);

// That of the mesh's vertices at a hit of refine(); none where they have none, or something has
// grown on them.
VertexColor color_of(const Scene& scene, const Found& found, const Hit& hit);

}  // namespace ensonify
