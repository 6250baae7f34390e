// Receiver noise that is correlated between beams as the beams overlap.
//
//   BeamNoise
#pragma once

#include <complex>
#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/sonar.h"
#include "synthesis/beam_mixing.h"

namespace ensonify {

// Isotropic noise arrives in every beam cell independently, n_i sqrt(d_i), d_i being the cell's
// width relative to the mean, and beam j adds the cells as it adds echoes:
//   p_j = sum_i w_ji sqrt(d_i) n_i / sqrt(sum_i w_ji^2 d_i)     w_ji of synthesis/beamforming.h
// Each beam keeps the power of n, and beams i and j have the covariance of their patterns.
class BeamNoise {
 public:
  explicit BeamNoise(const Sonar& sonar);

  // Adds the noise of a ping, E|p|^2 = power_pa2 in each sample, to `pressure_pa` [beams x
  // samples]. `key` and `ping` are those of draw_noise.
  void add(std::uint64_t key, std::uint32_t ping, double power_pa2, int samples,
           std::span<std::complex<float>> pressure_pa, const Workers& workers) const;

 private:
  int beams_;
  BeamMixer mixer_;
};

}  // namespace ensonify
