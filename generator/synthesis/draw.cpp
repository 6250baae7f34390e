#include "synthesis/draw.h"

#include <cmath>

namespace ensonify {
namespace {

std::uint64_t cell_key(int beam, int sample) {
  return (static_cast<std::uint64_t>(beam) << 32) | static_cast<std::uint32_t>(sample);
}

}  // namespace

std::complex<float> draw_amplitude(const Scatterer& scatterer, const RandomKeys& keys) {
  if (scatterer.standard_deviation == 0) return scatterer.mean;
  const ComplexDraw xi = complex_normal(keys.speckle, keys.speckle_ping, scatterer.key, 0);
  return {static_cast<float>(scatterer.mean.real() + scatterer.standard_deviation * xi.re),
          static_cast<float>(scatterer.mean.imag() + scatterer.standard_deviation * xi.im)};
}

std::complex<double> draw_volume(const RandomKeys& keys, int beam, int sample, double energy) {
  if (energy == 0) return 0;
  const ComplexDraw xi = complex_normal(keys.volume, keys.speckle_ping, cell_key(beam, sample), 0);
  const double rms = std::sqrt(energy);
  return {rms * xi.re, rms * xi.im};
}

std::complex<double> draw_noise(const RandomKeys& keys, int beam, int sample, double power_pa2) {
  const ComplexDraw xi = complex_normal(keys.noise, keys.noise_ping, cell_key(beam, sample), 0);
  const double rms = std::sqrt(power_pa2);
  return {rms * xi.re, rms * xi.im};
}

}  // namespace ensonify
