// Beam mixing as a convolution over beams: the weights depend on the distance of two sectors only.
#pragma once

#include <complex>
#include <vector>

#include "core/parallel.h"
#include "synthesis/cpu/fft.h"
#include "synthesis/mixing.h"

namespace ensonify {

class BeamMixer {
 public:
  explicit BeamMixer(const Mixing& mixing);

  // rows[j][n] <- scale_j sum_i weight_|i-j| rows[i][n] for n < columns; rows `stride` apart.
  void mix_amplitude(std::complex<double>* rows, int columns, int stride,
                     const Workers& workers) const;

  // The same with squared weights and scales, on real rows.
  void mix_power(double* rows, int columns, int stride, const Workers& workers) const;

 private:
  std::vector<double> kernel_spectrum(const std::vector<double>& weight) const;
  void convolve(std::complex<double>* column, const std::vector<double>& spectrum) const;

  int beams_;
  std::vector<double> scale_, power_scale_;
  ComplexFft forward_, backward_;
  std::vector<double> amplitude_spectrum_, power_spectrum_;  // real: the weights are even
};

}  // namespace ensonify
