#include "synthesis/draw.h"

#include <cmath>

namespace ensonify {

std::complex<float> draw_amplitude(const Scatterer& scatterer, const RandomKeys& keys) {
  if (scatterer.standard_deviation == 0) return scatterer.mean;
  const ComplexDraw xi = complex_normal(keys.speckle, keys.speckle_ping, scatterer.key, 0);
  return {static_cast<float>(scatterer.mean.real() + scatterer.standard_deviation * xi.re),
          static_cast<float>(scatterer.mean.imag() + scatterer.standard_deviation * xi.im)};
}

std::complex<double> draw_noise(const RandomKeys& keys, int beam, int sample, double power_pa2) {
  const std::uint64_t item =
      (static_cast<std::uint64_t>(beam) << 32) | static_cast<std::uint32_t>(sample);
  const ComplexDraw xi = complex_normal(keys.noise, keys.noise_ping, item, 0);
  const double rms = std::sqrt(power_pa2);
  return {rms * xi.re, rms * xi.im};
}

}  // namespace ensonify
