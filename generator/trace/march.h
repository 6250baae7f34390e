// A ray through the volumes: how much density lies on each step of its way.
#pragma once

#include <vector>

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

}  // namespace ensonify
