// The echoes of a ping over elevation, before pulse and beams spread them.
//
//   ElevationEcho  elevation_step_of
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>

namespace ensonify {

// Echoes of one surface or volume in a step of elevation and a 128th of a sample, at the peak of
// the pulse that the ideal beam cell receives.
struct ElevationEcho {
  std::int32_t sample = 0;  // the nearest one to the delay; may lie outside of the record
  std::uint16_t beam = 0;   // the beam cell of arrival
  std::int16_t step = 0;    // elevation_step_of the arrival
  float offset = 0;         // from the sample to the delay, in samples
  float diffuse_pa2 = 0;    // sum of S0^2 gain^2 variance
  std::complex<float> coherent_pa = 0;  // sum of S0 gain mean e^(-i 2 pi f_c delay)
  std::uint16_t instance = 0;
  std::uint16_t path = 0;  // 0 direct; others as SequenceInfo::paths
};

// The step k of an elevation, from k to k + 1 times the step; step 0 begins at the plane of the
// sonar. Elevations are those of Direction, in single precision.
inline std::int16_t elevation_step_of(float elevation_rad, double step_rad) {
  return static_cast<std::int16_t>(std::floor(double{elevation_rad} / step_rad));
}

}  // namespace ensonify
