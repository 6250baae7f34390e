// The scatterers of a fan whose cells are cut where surfaces need it (adaptive.h).
//
//   FanRaysMet  adaptive_surface_scatterers
#pragma once

#include <span>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/adaptive.h"
#include "trace/refracted.h"
#include "trace/tracer.h"

namespace ensonify {

// The hits of the fan's rays; `paths` as for surface_scatterer_list.
struct FanRaysMet {
  std::span<const Hit> hits;
  std::span<const RayPath> paths = {};
  std::span<const Hit> all_hits = {};  // as in FanMet
};

// Does the same as surface_scatterer_list, with a ray through the middle of every piece of the
// cells; a cell that is not cut keeps the fan's own ray. With sonar.rays_per_cell the pieces are
// those of adaptive_pieces; without, rays through them are traced first, and finer_pieces cuts
// cells once more. The key of a piece is that of the fan's ray, with the number of the piece,
// counted from 0, in the upper 32 bits.
ScattererList adaptive_surface_scatterers(const Fan& fan, const FanRaysMet& met,
                                          const ResolutionCell& cell, const Tracer& tracer,
                                          const Pose& sonar_in_world,
                                          const SurfaceScattering& scattering,
                                          const Workers& workers);

}  // namespace ensonify
