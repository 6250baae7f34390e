// Beam mixing in double precision.
//
//   BeamMixer   a convolution over beams, because the weights depend only on the distance of two
//               beam cells; of unequal beams, plain sums
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "synthesis/beamforming.h"
#include "synthesis/fft.h"

namespace ensonify {

class BeamMixer {
 public:
  explicit BeamMixer(const Mixing& mixing);

  // rows[j][n] <- scale_j sum_i w_ji rows[i][n] for n < columns; rows `stride` apart.
  void mix_amplitude(std::complex<double>* rows, int columns, int stride,
                     const Workers& workers) const;

  // The same with squared weights and scales, on real rows.
  void mix_power(double* rows, int columns, int stride, const Workers& workers) const;

  // The memory of the weights of unequal beams.
  std::uint64_t matrix_bytes() const {
    return (amplitude_matrix_.size() + power_matrix_.size()) * sizeof(double);
  }

 private:
  std::vector<double> kernel_spectrum(const std::vector<double>& weight) const;
  template <class Value>
  void mix_by_matrix(Value* rows, int columns, int stride, const std::vector<double>& matrix,
                     const Workers& workers) const;
  void convolve(std::complex<double>* column, const std::vector<double>& spectrum) const;

  int beams_;
  std::vector<double> scale_, power_scale_;
  ComplexFft forward_, backward_;
  std::vector<double> amplitude_spectrum_, power_spectrum_;  // real: the weights are even
  // [beams][cells] with the scales, of unequal beams; otherwise empty.
  std::vector<double> amplitude_matrix_, power_matrix_;
};

}  // namespace ensonify
