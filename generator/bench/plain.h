// References for the backend: the time series in double precision, and the plain methods.
//
//   exact_bins  exact_spectra  exact_series   term by term: the reference backend's sum over every
//                     scatterer, bin and sector, fast enough for millions of scatterers because
//                     phasors are turned from bin to bin (in double precision, which costs 1e-13)
//   SeriesError  series_error
//   PlainPhasors  PlainMethod   done as well as they can be: sum over the scatterers of a sector
//                     at every bin, product with the full mixing matrix, one transform a beam;
//                     single precision, widest vectors, the series alone without expected power
//   FftRows  exact_inverse_transform   transforms of many rows by FFTW, apart from the backends'
#pragma once

#include <complex>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bench/kernels.h"
#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/fft.h"

namespace ensonify {

// Sums of some scatterers at every bin, f_c - b/2 first, times the source level and `pulse`, the
// pulse_spectrum of the setup; `amplitude` as drawn, one a scatterer. later_s(scatterer) is added
// to its delay.
std::vector<std::complex<double>> exact_bins(
    const SynthesisSetup& setup, std::span<const std::complex<double>> pulse,
    std::span<const Scatterer> scatterers, std::span<const std::complex<float>> amplitude,
    const KernelTable& kernels, const std::function<double(const Scatterer&)>& later_s);

// [beams x transform], f_c first.
std::vector<std::complex<double>> exact_spectra(const SynthesisSetup& setup,
                                                const ScattererList& list,
                                                std::span<const std::complex<float>> amplitude,
                                                const KernelTable& kernels, const Workers& workers);

// [beams x samples].
std::vector<std::complex<double>> exact_series(const SynthesisSetup& setup,
                                               std::vector<std::complex<double>> spectra,
                                               const Workers& workers);

struct SeriesError {
  double relative = 0;     // L2 over the record
  double worst_tenth = 0;  // the largest over a tenth of the record against its own norm; tenths
                           // under 1e-6 of the record's norm are left out
};

SeriesError series_error(std::span<const std::complex<float>> series,
                         std::span<const std::complex<double>> exact, int beams);

// e^(+i...), unscaled, with the plan that FFTW measures to be the fastest. Made by one thread at a
// time.
class FftRows {
 public:
  FftRows(int length, int stride, int rows);
  ~FftRows();
  FftRows(const FftRows&) = delete;
  FftRows& operator=(const FftRows&) = delete;

  // The first `samples` of the transform of each row; out: [rows x samples].
  void run(std::complex<float>* out, int samples, const Workers& workers);
  // [rows x stride], zero at first, on a 64-byte boundary.
  std::complex<float>* data() { return rows_of_bins_.data(); }

 private:
  int length_, stride_, rows_;
  AlignedBuffer<std::complex<float>> rows_of_bins_;
  void* plan_;
};

// rows: [count x length].
void exact_inverse_transform(std::complex<double>* rows, int length, int count,
                             const Workers& workers);

enum class RaySum {
  direct,      // sine and cosine for each scatterer and bin
  recurrence,  // a phasor for each scatterer, turned from bin to bin
};

// Scatterers as the plain kernels take them: phases are fractions of a turn in units of 2^-64.
class PlainPhasors {
 public:
  PlainPhasors(const SynthesisSetup& setup, std::size_t count);
  // Delays times frequencies are reduced to fractions of a turn in double precision.
  void set(std::size_t i, std::complex<float> amplitude, double delay_s);
  // Sums at every bin, f_c - b/2 first, into `re` and `im`, conjugate: the sum turns forwards, an
  // echo's phase backwards.
  void sum(RaySum method, const KernelTable& kernels);

  std::vector<float> re, im;

 private:
  int bins_;
  double bin_hz_, first_hz_;
  std::vector<std::uint64_t> start_, step_;
  std::vector<float> magnitude_, workspace_;
};

class PlainMethod {
 public:
  PlainMethod(const SynthesisSetup& setup, const KernelTable& kernels);

  // Spectra of these sectors; `amplitude` as drawn, one a scatterer.
  void ray_sum(RaySum method, const ScattererList& list,
               std::span<const std::complex<float>> amplitude, std::span<const int> sectors,
               const Workers& workers);
  // Mixes all beam cells into all beams.
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
