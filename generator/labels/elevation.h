// The echoes of a ping over elevation.
//
//   ElevationInput  elevation_echoes
//   elevation_step_of
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/elevation.h"
#include "core/parallel.h"
#include "core/scatterers.h"

namespace ensonify {

struct ElevationInput {
  const ScattererList& scatterers;
  std::span<const ElevationEcho> volumes;  // sorted by beam (trace/volume.h)
  double bandwidth_hz = 0;
  double source_pa_m = 0;
  double step_rad = 0;
};

// The number of the step that contains an elevation; step 0 begins at the plane of the sonar.
inline std::int16_t elevation_step_of(double elevation_rad, double step_rad) {
  return static_cast<std::int16_t>(std::floor(elevation_rad / step_rad));
}

// All echoes of the list, and of volumes, sorted by beam, sample, step, offset, instance and path.
// Those of one beam, step, instance and path whose delays lie in the same 128th of a sample are one
// entry, with their mean delay by power: for a spectrum of width b, this changes the expected power
// of a pixel by 5e-5 of their share at most, and by 2e-5 if the delays are spread evenly.
// Echoes without power are left out.
std::vector<ElevationEcho> elevation_echoes(const ElevationInput& input, const Workers& workers);

}  // namespace ensonify
