// The random draws of a ping, defined once for all backends, on host and device.
//
//   amplitude_part  drawn_amplitude  draw_amplitude   for a scatterer
//   cell_draw  draw_volume  draw_noise                for a sample of a beam (or of an element)
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>

#include "core/compile_targets.h"
#include "core/random.h"
#include "core/scatterers.h"
#include "synthesis/backend.h"

namespace ensonify {

// The real or imaginary part of a = mean + standard_deviation xi (Choi et al. 2021, Eq 14), rounded
// to float as in exports.
template <class Real>
ENSONIFY_HD inline float amplitude_part(float mean, float standard_deviation, Real normal) {
  return static_cast<float>(mean + standard_deviation * normal);
}

// `Complex` is any type made of two floats.
template <class Complex>
ENSONIFY_HD inline Complex drawn_amplitude(float mean_re, float mean_im, float standard_deviation,
                                           std::uint64_t speckle_key, std::uint32_t ping,
                                           std::uint64_t key) {
  if (standard_deviation == 0) return {mean_re, mean_im};
  const ComplexDraw xi = complex_normal(speckle_key, ping, key, 0);
  return {amplitude_part(mean_re, standard_deviation, xi.re),
          amplitude_part(mean_im, standard_deviation, xi.im)};
}

inline std::complex<float> draw_amplitude(const Scatterer& s, const RandomKeys& keys) {
  return drawn_amplitude<std::complex<float>>(s.mean.real(), s.mean.imag(), s.standard_deviation,
                                              keys.speckle, keys.speckle_ping, s.key);
}

// A circular complex normal number with E|a|^2 = rms^2, keyed by (row, sample). A row is a beam or
// an element.
ENSONIFY_HD inline ComplexDraw cell_draw(std::uint64_t key, std::uint32_t ping, std::int64_t row,
                                         int sample, double rms) {
  const auto item = (static_cast<std::uint64_t>(row) << 32) | static_cast<std::uint32_t>(sample);
  const ComplexDraw xi = complex_normal(key, ping, item, 0);
  return {rms * xi.re, rms * xi.im};
}

// The echo of the volumes in one beam cell and sample, with E|a|^2 = energy.
inline std::complex<double> draw_volume(const RandomKeys& keys, int beam, int sample,
                                        double energy) {
  if (energy == 0) return 0;
  const ComplexDraw a = cell_draw(keys.volume, keys.speckle_ping, beam, sample, std::sqrt(energy));
  return {a.re, a.im};
}

// The noise of one sample, with E|p|^2 = power.
inline std::complex<double> draw_noise(const RandomKeys& keys, int beam, int sample,
                                       double power_pa2) {
  const ComplexDraw p = cell_draw(keys.noise, keys.noise_ping, beam, sample, std::sqrt(power_pa2));
  return {p.re, p.im};
}

}  // namespace ensonify
