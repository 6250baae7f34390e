// The plain methods that the backend is measured against, done as well as they can be: sum over
// the scatterers of every sector at every bin, product with the full mixing matrix, one transform a
// beam. Single precision, widest vectors. They give the series alone, without expected power.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/fft_rows.h"
#include "bench/kernels.h"
#include "core/parallel.h"
#include "synthesis/backend.h"

namespace ensonify {

// The fraction of turns in units of 2^-64, as the kernels take phases.
std::uint64_t fixed_point_turns(double turns);

enum class RaySum {
  direct,      // sine and cosine for each scatterer and bin
  recurrence,  // a phasor for each scatterer, turned from bin to bin
};

class PlainMethod {
 public:
  PlainMethod(const SynthesisSetup& setup, const KernelTable& kernels);

  // Spectra of these sectors; `amplitude` as drawn, one a scatterer. Delays times frequencies are
  // reduced to fractions of a turn in double precision.
  void ray_sum(RaySum method, const ScattererList& list,
               std::span<const std::complex<float>> amplitude, std::span<const int> sectors,
               const Workers& workers);
  // All sectors into all beams.
  void mix(const Workers& workers);
  // Spectra of the beams to series, [beams x samples].
  void transform(std::vector<std::complex<float>>& series, const Workers& workers);

  // Of a sector, after ray_sum: transform() bins, f_c first.
  const std::complex<float>* spectrum(int sector) const {
    return sector_.data() + std::size_t(sector) * stride_;
  }

 private:
  SynthesisSetup setup_;
  const KernelTable& kernels_;
  int stride_;                               // from row to row
  std::vector<float> pulse_re_, pulse_im_;   // S0 S(f_m), m = 0 first
  std::vector<float> weight_;                // as MixPanel wants them
  std::vector<std::complex<float>> sector_;  // [beams x stride]
  FftRows beam_;                             // [beams x stride]
};

}  // namespace ensonify
