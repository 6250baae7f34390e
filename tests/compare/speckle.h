// Pings of synthetic speckle, whose statistics have closed forms.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <vector>

#include "compare/pings.h"
#include "core/random.h"

namespace ensonify::test {

struct SpeckleSpec {
  int samples = 160, beams = 48, pings = 24, blocks = 12;
  double range_step_m = 0.05, azimuth_step_rad = 0.01;
  std::uint64_t seed = 1;
  int smoothing = 1;       // rows over which complex amplitudes are added
  double shape = 0;        // of a gamma factor of each pixel, 1, 2, ...; 0: none
  double power = 1;        // of the amplitude
  // Factor on the amplitude of ping, row and column.
  std::function<double(int, int, int)> gain = {};
};

inline PolarPings speckle_pings(const SpeckleSpec& spec) {
  PolarPings pings;
  for (int r = 0; r < spec.samples; ++r) pings.range_m.push_back(1 + r * spec.range_step_m);
  for (int c = 0; c < spec.beams; ++c) {
    pings.azimuth_rad.push_back((c - spec.beams / 2) * spec.azimuth_step_rad);
  }
  const std::uint64_t key = stream_key(spec.seed, Stream::speckle, 0);
  const auto draw = [&](int ping, int row, int column, std::uint32_t number) {
    const auto item = static_cast<std::uint64_t>(row + 1000) * 10'000 +
                      static_cast<std::uint64_t>(column);
    const auto xi = complex_normal(key, static_cast<std::uint32_t>(ping), item, number);
    return std::complex<double>(xi.re, xi.im);
  };
  for (int p = 0; p < spec.pings; ++p) {
    std::vector<float> amplitude;
    for (int r = 0; r < spec.samples; ++r) {
      for (int c = 0; c < spec.beams; ++c) {
        std::complex<double> sum = 0;
        for (int k = 0; k < spec.smoothing; ++k) sum += draw(p, r + k, c, 0);
        // A sum of exponentials: a gamma factor of a whole shape and mean 1.
        double texture = spec.shape > 0 ? 0 : 1;
        for (std::uint32_t k = 1; k <= static_cast<std::uint32_t>(spec.shape); ++k) {
          texture += std::norm(draw(p, r, c, k)) / spec.shape;
        }
        const double a = std::abs(sum) * std::sqrt(texture);
        const double gain = spec.gain ? spec.gain(p, r, c) : 1;
        amplitude.push_back(static_cast<float>(std::pow(a * gain, spec.power)));
      }
    }
    pings.amplitude.push_back(std::move(amplitude));
    pings.time_s.push_back(0.1 * p);
    pings.block.push_back(static_cast<std::uint32_t>(p * spec.blocks / spec.pings));
  }
  return pings;
}

}  // namespace ensonify::test
