// Rays where those of the fan are too few: a surface that is seen at a slant passes many cells of
// range between two rays, and speckle needs many scatterers in each.
//
//   ResolutionCell  resolution_cell
//   scatterers_per_cell   how many the rays of a fan give
//   undersampled_share         where they are too few
//   adaptive_pieces  adaptive_surface_scatterers
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "trace/refracted.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// Full widths at half power of the beam in azimuth and of the pulse in range.
struct ResolutionCell {
  double width_rad = 0;
  double range_m = 0;
};
// `transform` bins of the pulse's spectrum (Record::transform).
ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform);

// How a surface that a ray meets recedes with the ray's angles, as a plane does: change of range in
// m/rad.
struct Slant {
  double azimuth_m = 0, elevation_m = 0;
};
// `normal` and the direction in the sonar's frame.
Slant slant_of(Vec3 normal, double range_m, double azimuth_rad, double elevation_rad);

// Rays of a fan of the sonar's in one resolution cell of a surface: those of the area of angles
//   width_rad range_m / |dr/delevation|,   min(width_rad, range_m / |dr/dazimuth|) fan
// whichever is smaller.
double scatterers_per_cell(const Sonar& sonar, const ResolutionCell& cell, const Slant& slant);

// The share of the range that the surface rays pass over (in all sectors) where a cell has fewer
// than `least` scatterers, after the cuts where sonar.rays_per_cell is set. 0 where no ray meets
// anything.
double undersampled_share(const Sonar& sonar, const ResolutionCell& cell, const Fan& fan,
                          std::span<const Hit> hits, const Pose& sonar_in_world, double least);

// Into how many equal pieces of elevation each cell of the fan is cut so that a resolution cell has
// sonar.rays_per_cell of them, kMostPieces at most; [fan.size()]. A cell whose ray misses is cut as
// its neighbours in elevation are.
inline constexpr int kMostPieces = 1024;
std::vector<std::uint16_t> adaptive_pieces(const Sonar& sonar, const ResolutionCell& cell,
                                           const Fan& fan, std::span<const Hit> hits,
                                           const Pose& sonar_in_world);

// What the rays of the fan met; `paths` as surface_scatterer_list wants them.
struct FanRaysMet {
  std::span<const Hit> hits;
  std::span<const RayPath> paths = {};
};

// As surface_scatterer_list, with a ray through the middle of every piece. Pieces of one cell are
// keyed by the fan's ray and, in the upper half, by their number from 0.
ScattererList adaptive_surface_scatterers(const Fan& fan, const FanRaysMet& met,
                                          std::span<const std::uint16_t> pieces,
                                          const Tracer& tracer, const Pose& sonar_in_world,
                                          const SurfaceScattering& scattering,
                                          const Workers& workers);

}  // namespace ensonify
