// Beam mixing in few sums, two ways.
//
//   BeamMixer                      a convolution over beams: the weights depend on the distance of
//                                  two sectors only
//   BeamNodes  choose_beam_nodes   few nodes across the fan, since the weights are a smooth
//                                  function of the beam: W = P K P^T, where P spreads each beam
//                                  over a few neighbouring nodes and K mixes the nodes
#pragma once

#include <complex>
#include <vector>

#include "core/parallel.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/fft.h"

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

struct BeamNodes {
  int beams = 0;
  int nodes = 0;               // even, placed symmetrically about the fan's middle
  int width = 0;               // nodes that a beam reaches
  double error = 0;            // relative L2 of the worst of the sampled columns of W
  std::vector<int> first;      // [beams]
  std::vector<double> weight;  // [beams][width]: P
  std::vector<double> matrix;  // [nodes][nodes]: K, symmetric and persymmetric
};

// `weight` is W's by distance. The cheapest with an error of at most `tolerance`; nodes = beams (or
// one more) with K = W where nothing less will do. `row_cost` is that of transforming one node's
// record, in multiplications per sample.
BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost);

}  // namespace ensonify
