// Adaptive refinement adds rays where the fan has too few. At small grazing angles a surface
// crosses many range cells between two rays, and speckle needs many scatterers in each of them.
//
//   ResolutionCell  resolution_cell
//   scatterers_per_cell   how many the rays of a fan give
//   undersampled_share    where they are too few
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

// Full widths at half power of the beam in azimuth (the mean of unequal ones, in whose place each
// beam's own width counts below) and of the pulse in range.
struct ResolutionCell {
  double width_rad = 0;
  double range_m = 0;
};
// `transform` bins of the pulse's spectrum (Record::transform).
ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform);

// Change of range with the angles of the ray at a hit, in m/rad, on the tangent plane of the
// surface.
struct Slant {
  double azimuth_m = 0, elevation_m = 0;
};
// `normal` and the angles are in the sonar's frame.
Slant slant_of(Vec3 normal, double range_m, double azimuth_rad, double elevation_rad);

// Number of the fan's rays in one resolution cell of a surface: the area of the cell in angles,
//   min(width_rad range_m / |dr/delevation|, min(width_rad, range_m / |dr/dazimuth|) fan),
// divided by the area that belongs to one ray, in a beam cell of this width relative to the mean.
double scatterers_per_cell(const Sonar& sonar, const ResolutionCell& cell, const Slant& slant,
                           double relative_width = 1);

// The rays of each beam cell cover a length of range along surfaces. Returns the share of this
// length, summed over all beam cells, in which a resolution cell has fewer than `least` scatterers.
// Pieces count as rays if sonar.rays_per_cell is set. Returns 0 if no ray meets anything.
double undersampled_share(const Sonar& sonar, const ResolutionCell& cell, const Fan& fan,
                          std::span<const Hit> hits, const Pose& sonar_in_world, double least);

// [fan.size()]: the number of equal pieces in elevation into which each cell of the fan is cut, so
// that a resolution cell holds sonar.rays_per_cell of them; at most kMostPieces. A cell whose ray
// misses is cut like its neighbors in elevation.
inline constexpr int kMostPieces = 1024;
std::vector<std::uint16_t> adaptive_pieces(const Sonar& sonar, const ResolutionCell& cell,
                                           const Fan& fan, std::span<const Hit> hits,
                                           const Pose& sonar_in_world);

// The hits of the fan's rays; `paths` as for surface_scatterer_list.
struct FanRaysMet {
  std::span<const Hit> hits;
  std::span<const RayPath> paths = {};
};

// Does the same as surface_scatterer_list, with a ray through the middle of every piece. The key of
// a piece is that of the fan's ray, with the number of the piece, counted from 0, in the upper 32
// bits.
ScattererList adaptive_surface_scatterers(const Fan& fan, const FanRaysMet& met,
                                          std::span<const std::uint16_t> pieces,
                                          const Tracer& tracer, const Pose& sonar_in_world,
                                          const SurfaceScattering& scattering,
                                          const Workers& workers);

}  // namespace ensonify
