// The surfaces that the rays of a fan meet first, before the echoes of a range are summed.
//
//   front_view
#pragma once

#include <span>

#include "core/parallel.h"
#include "core/ping.h"
#include "trace/refracted.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// One pixel for each ray, at the ray's direction of departure: [elevations x azimuths], lowest
// elevation and beam 0 first. `hits` and `paths` are those of trace_fan, in the order of ray_index.
//   range_m         Hit::range_m: the distance, or c times the one-way travel time of refracted rays
//   normal_*        of the surface, on the side of the straight line to the sonar
//   backscatter_db  10 log10 of surface_backscatter: the expected incoherent cross-section of a
//                   unit of surface at the ray's incidence; kNoEnergyDb at least
//   instance        `semantic` stays 0
// NaN and 0 where a ray misses, or its range is not in [range_min, range_max]. Values are rounded
// to kFrontRangeQuantum_m, kFrontNormalQuantum and kFrontLevelQuantum_db. Point targets, volumes
// and paths over several surfaces are not in it.
FrontView front_view(const Fan& fan, std::span<const Hit> hits, std::span<const RayPath> paths,
                     const SurfaceScattering& scattering, const Pose& sonar_in_world,
                     const Workers& workers);

inline constexpr double kFrontRangeQuantum_m = 1.0 / (1 << 13);
inline constexpr double kFrontNormalQuantum = 1.0 / (1 << 12);
inline constexpr double kFrontLevelQuantum_db = 1.0 / (1 << 8);

}  // namespace ensonify
