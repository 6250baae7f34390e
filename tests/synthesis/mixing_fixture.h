// The mixing of beams against its definition.
#pragma once

#include <complex>
#include <vector>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "synthesis/beamforming.h"
#include "synthesis/beam_mixing.h"

namespace ensonify::test {

// Protects the mixer against blocks that do not come out even, and the squares of powers: it is the
// plain product with the matrix, and leaves what stands behind the columns alone.
inline void check_mixer(const Mixing& mixing, int beams) {
  constexpr int kColumns = 13, kStride = 16;
  AlignedBuffer<std::complex<double>> rows(std::size_t(beams) * kStride);
  AlignedBuffer<double> power(std::size_t(beams) * kStride);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = {uniform(1, 0, i, 0) - 0.5, uniform(1, 0, i, 1) - 0.5};
    power[i] = uniform(1, 0, i, 2);
  }
  const std::vector<std::complex<double>> before(rows.begin(), rows.end());
  const std::vector<double> power_before(power.begin(), power.end());
  const BeamMixer mixer(mixing);
  mixer.mix_amplitude(rows.data(), kColumns, kStride, Workers(2));
  mixer.mix_power(power.data(), kColumns, kStride, Workers(2));
  for (int j = 0; j < beams; ++j) {
    for (int n = 0; n < kStride; ++n) {
      const bool is_mixed = n < kColumns;
      std::complex<double> amplitude = is_mixed ? 0 : before[j * kStride + n];
      double square = is_mixed ? 0 : power_before[j * kStride + n];
      for (int i = 0; is_mixed && i < beams; ++i) {
        const double w = mixing.scale[j] * mixing.at(j, i);
        amplitude += w * before[i * kStride + n];
        square += w * w * power_before[i * kStride + n];
      }
      REQUIRE(std::abs(rows[j * kStride + n] - amplitude) < 1e-13);
      REQUIRE(power[j * kStride + n] == Approx(square).margin(1e-13));
    }
  }
}

}  // namespace ensonify::test
