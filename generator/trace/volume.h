// Reverberation of the water itself, up to the first surface that each ray meets, and what it takes
// from the sound that passes.
//
//   DensityColumn  march  extinction_db   how much density lies on each step of a ray
//   volume_echoes         expected energy of every volume
//   attenuate             what is behind volumes gets weaker
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"
#include "world/shapes.h"
#include "world/volumes.h"

namespace ensonify {

// Integrals of the density over the steps [k step_m, (k + 1) step_m) of a ray, in metres of density
// 1; zero outside [first, last).
struct DensityColumn {
  int first = 0, last = 0;
  std::vector<double> length_m;  // as long as the longest ray so far

  void clear();
  void add(int step, double more_m);
};

// The volume as a ray of the world (of unit length) meets it up to end_m. Boxes are exact; a grid
// is looked at in the middle of each step, or of parts of it no longer than its spacing, 64 at
// most. Bricks without density are skipped, which changes nothing.
void march(const Volume& volume, const Ray& ray, double step_m, double end_m,
           DensityColumn& column);

// The extinction along a ray up to end_m, of all volumes, one way.
double extinction_db(const std::vector<Volume>& volumes, const Ray& ray, double step_m,
                     double end_m, DensityColumn& column);

// One echo a volume of the world, in its order. In sector j and sample n >= 1 of range r = c
// n/(2b), within [range_min, range_max]: s_v (sum over the sector's rays: dOmega B_el^2 B_tx^2
// int rho 10^(-2A/10) dr') r^2 (two_way_loss(r))^2, r' within [r - c/(4b), r + c/(4b)] and no
// farther than the ray's surface; rho the volume's density and A the extinction of all volumes on
// the way there in dB, both in steps of c/(4b). Where no volume has bounds or extinction, a ray
// counts with the whole cell, c/(2b), if it reaches r.
std::vector<VolumeEcho> volume_echoes(const Fan& fan, std::span<const Hit> hits,
                                      const std::vector<Volume>& volumes,
                                      const Pose& sonar_in_world, const Sonar& sonar,
                                      const Water& water, const Record& record,
                                      const Workers& workers);

// Multiplies each gain of a direct echo by 10^(-2A/20), A as above.
void attenuate(ScattererList& list, const std::vector<Volume>& volumes, const Pose& sonar_in_world,
               const Sonar& sonar, const Water& water, const Workers& workers);

}  // namespace ensonify
