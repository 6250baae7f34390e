// The random draws of a ping: amplitudes of scatterers and of volumes, noise of samples.
#pragma once

#include <complex>
#include <cstdint>

#include "core/random.h"
#include "core/scatterers.h"
#include "synthesis/backend.h"

namespace ensonify {

// a = mean + standard_deviation xi, rounded to float as it is exported (Eq 14).
std::complex<float> draw_amplitude(const Scatterer& scatterer, const RandomKeys& keys);

// What the volumes throw back from one cell: circular complex normal with E|a|^2 = energy, keyed by
// (beam, sample).
std::complex<double> draw_volume(const RandomKeys& keys, int beam, int sample, double energy);

// Noise of one sample: circular complex normal with E|p|^2 = power, keyed by (beam, sample).
std::complex<double> draw_noise(const RandomKeys& keys, int beam, int sample, double power_pa2);

}  // namespace ensonify
