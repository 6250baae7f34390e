// Adaptive refinement adds rays where the fan has too few: between two rays, a surface at a small
// grazing angle crosses many range cells, and an object can hide.
//
//   ResolutionCell  resolution_cell
//   Slant  slant_of       how the range changes along a surface
//   scatterers_per_cell   how many the rays of a fan give
//   gapped_share          where they leave gaps
//   adaptive_pieces       the parts into which cells of the fan are cut
//   finer_pieces          ... and are cut once more, where the rays through those parts show edges
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "trace/refracted.h"
#include "trace/surface_scattering.h"
#include "trace/tracer.h"

namespace ensonify {

// Full widths at half power of the beam in azimuth (the mean of unequal ones, in whose place each
// beam's own width counts below) and of the pulse in range.
struct ResolutionCell {
  double width_rad = 0;
  double range_m = 0;
  // Between echoes of one column of rays: the longest step that keeps the expected level within
  // 3/4 kLevelErrorDb, and the one beyond which some pixels hear none of them, c/b.
  double step_m = 0, gap_m = 0;
};
// `transform` bins of the pulse's spectrum (Record::transform).
ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform);

// Rms of the error of the expected level over an even surface, if Sonar::rays_per_cell is absent.
inline constexpr double kLevelErrorDb = 0.02;

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

// A fan and what its rays met.
struct FanMet {
  const Fan& fan;
  std::span<const Hit> hits;  // [fan.size()]
  const Pose& sonar_in_world;
  // If the fan has the cells of a group of beams alone, the hits of all groups, each at its own
  // time.
  std::span<const Hit> all_hits = {};

  std::span<const Hit> whole() const { return all_hits.empty() ? hits : all_hits; }
  // Where the hit of a ray is among them.
  std::size_t place(std::size_t ray) const {
    const std::size_t rays = fan.rays_per_beam();
    return static_cast<std::size_t>(fan.beam_of(ray / rays)) * rays + ray % rays;
  }
};

// The rays of each beam cell cover a length of range along surfaces. Returns the share of this
// length, summed over all beam cells, in which the steps between rays exceed gap_m, or those
// between `pieces` if there are any. Returns 0 if no ray meets anything.
double gapped_share(const SurfaceScattering& scattering, const ResolutionCell& cell,
                    const FanMet& met, std::span<const std::uint16_t> pieces = {});

// [fan.size()]: the number of equal pieces in elevation into which each cell of the fan is cut; at
// most kMostPieces. With sonar.rays_per_cell so many that a resolution cell holds that number of
// pieces. Without, so many that they are at most step_m apart in range on even surfaces, about half
// as far apart on others, and that a resolution cell holds kFineScatterers if the level of the
// material depends on their number (rician). A surface is even where the hits above and below are
// as far away as tangent planes tell. A cell whose ray misses is cut like its neighbors in
// elevation.
inline constexpr int kMostPieces = 1024;
inline constexpr int kFineScatterers = 30;
std::vector<std::uint16_t> adaptive_pieces(const SurfaceScattering& scattering,
                                           const ResolutionCell& cell, const FanMet& met,
                                           const Workers& workers);

// The rays through all pieces of the cells of a beam that are cut, by ray and piece.
struct PieceHits {
  std::vector<Hit> hits;
  std::vector<RayPath> paths;  // empty for straight rays
};

// `pieces` with more of them in cells at an edge and where a surface curves within them. A cell is
// at an edge if two consecutive rays of its column meet different instances, or its ray and that of
// an adjacent column do, or an adjacent column has an edge beside it. A resolution cell of each
// surface in and beside such a cell gets kFineScatterers. Where consecutive rays on one instance
// are further apart than step_m, the count rises to half that step, at most to twice that of an
// edge. `first`: by beam.
std::vector<std::uint16_t> finer_pieces(const SurfaceScattering& scattering,
                                        const ResolutionCell& cell, const FanMet& met,
                                        std::span<const std::uint16_t> pieces,
                                        std::span<const PieceHits> first, const Workers& workers);

}  // namespace ensonify
