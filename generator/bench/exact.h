// The series in double precision, term by term: what errors are measured against. The reference
// backend's sum over every scatterer, bin and sector, fast enough for millions of scatterers
// because phasors are turned from bin to bin (in double precision, which costs 1e-13).
//
//   exact_spectra   of all sectors
//   exact_series    of all beams
//   SeriesError     series_error
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "bench/kernels.h"
#include "core/parallel.h"
#include "synthesis/backend.h"

namespace ensonify {

// [beams x transform], f_c first; `amplitude` as drawn, one a scatterer.
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

}  // namespace ensonify
