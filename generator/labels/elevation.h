// The echoes of a ping over elevation.
//
//   ElevationInput  elevation_echoes
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"

namespace ensonify {

struct ElevationInput {
  const ScattererList& scatterers;
  std::span<const ElevationEcho> volumes;  // sorted by beam (trace/volume.h)
  const Sonar& sonar;
  double source_pa_m = 0;
  double step_rad = 0;
};

// All echoes of the list, and of volumes, sorted by beam, sample, step, offset, instance and path.
// Those of one beam, step, instance and path whose delays lie in the same 128th of a sample are one
// entry, with their mean delay by power: for a flat spectrum, this changes the expected power of a
// pixel by 5e-5 of their share at most, and by 2e-5 if the delays are spread evenly. Echoes without
// power are left out.
std::vector<ElevationEcho> elevation_echoes(const ElevationInput& input, const Workers& workers);

}  // namespace ensonify
