// Reverberation of the water up to the first surface that each ray meets, and extinction of sound
// by the water.
//
//   DensityColumn  march  extinction_db   how much density lies on each step of a ray
//   volume_echoes         expected energy of every volume
//   volume_elevation_echoes   ... by elevation
//   attenuate             weakens echoes behind volumes
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"
#include "world/shapes.h"
#include "world/volumes.h"

namespace ensonify {

// Integrals of the density over the steps [k step_m, (k + 1) step_m) of a ray, in meters of density
// 1; zero outside [first, last).
struct DensityColumn {
  int first = 0, last = 0;
  std::vector<double> length_m;  // as long as the longest ray so far

  void clear();
  void add(int step, double more_m);
};

// The density of a volume along a ray (of the world, with unit direction) up to end_m. Boxes are
// exact. A grid is sampled in the middle of each step, or of at most 64 parts of it no longer than
// the grid's spacing. Bricks without density are skipped, which does not change the result. Patches
// are sampled in the middle of each step, or of at most 64 parts of it, linearly between points
// that are an eighth of the correlation length apart; `has_patches` false gives their mean.
void march(const Volume& volume, const Ray& ray, double step_m, double end_m,
           DensityColumn& column, bool has_patches = true);

// The one-way extinction of all volumes along a ray up to end_m, in dB. That of patches is the mean
// one, since sound crosses many of them. `column` is a buffer.
double extinction_db(const std::vector<Volume>& volumes, const Ray& ray, double step_m,
                     double end_m, DensityColumn& column);

// One echo per volume of the world, in its order. In beam cell j and sample n >= 1 of range
// r = c n/(2b), within [range_min, range_max], its energy is
//   s_v (sum over rays: dOmega B_el^2 B_tx^2 int rho 10^(-2A/10) dr') r^2 (two_way_loss(r))^2
// over the rays of the beam cell, with r' in [r - c/(4b), r + c/(4b)] and no farther than the ray's
// surface. rho is the volume's density and A the one-way extinction of all volumes up to r' in dB,
// both in steps of c/(4b). If no volume has bounds, patches or extinction, a ray that reaches r
// counts with the whole cell, c/(2b).
std::vector<VolumeEcho> volume_echoes(const Fan& fan, std::span<const Hit> hits,
                                      const std::vector<Volume>& volumes,
                                      const Pose& sonar_in_world, const Sonar& sonar,
                                      const Water& water, const Record& record,
                                      const Workers& workers);

// The same energies by steps of elevation (core/scatterers.h), each from the rays with such an
// elevation, sorted by beam. Samples and steps without energy are left out.
std::vector<ElevationEcho> volume_elevation_echoes(const Fan& fan, std::span<const Hit> hits,
                                                   const std::vector<Volume>& volumes,
                                                   const Pose& sonar_in_world, const Sonar& sonar,
                                                   const Water& water, const Record& record,
                                                   double step_rad, const Workers& workers);

// Multiplies the gain of each direct echo by 10^(-2A/20), with A as above.
void attenuate(ScattererList& list, const std::vector<Volume>& volumes, const Pose& sonar_in_world,
               const Sonar& sonar, const Water& water, const Workers& workers);

}  // namespace ensonify
