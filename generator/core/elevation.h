// The echoes of a ping over elevation, before pulse and beams spread them.
//
//   ElevationEcho
#pragma once

#include <cstdint>

namespace ensonify {

// Echoes of one surface or volume in a step of elevation and a 128th of a sample. Powers are those
// of the peak of the pulse that the ideal beam cell receives: S0^2 gain^2 times variance and
// |mean|^2 of the amplitude.
struct ElevationEcho {
  std::int32_t sample = 0;    // the nearest one to the delay; may lie outside of the record
  std::uint16_t beam = 0;     // the beam cell of arrival
  std::int16_t step = 0;      // arrival in [step, step + 1) times the step of elevation
  float offset = 0;           // from the sample to the delay, in samples
  float diffuse_pa2 = 0;      // of random amplitudes: powers add
  float coherent_pa2 = 0;     // of fixed amplitudes: pressures add
  std::uint16_t instance = 0;
  std::uint16_t path = 0;     // 0 direct; others as SequenceInfo::paths
};

}  // namespace ensonify
