// The case of an array: what it is measured against, with sums of its own.
//
//   ArrayErrors      check_array       against the definition, in double precision
//   ArrayPlainTimes  time_plain_array  per scatterer, element and bin
//   time_array_stages
#pragma once

#include <complex>
#include <vector>

#include "bench/stages.h"

namespace ensonify {

// Of `beams` beams evenly spread over the fan, every element and bin summed.
SeriesError check_array(const Bench& bench, const ScattererList& list,
                        const std::vector<std::complex<float>>& amplitude, const PingSeries& series,
                        int beams, const Workers& workers);

// Spectra of all elements by plain sums: a few elements are timed, over a few of the sectors, and
// scaled. Their beams are taken to cost nothing.
PlainTimes time_plain_array(const Bench& bench, const ScattererList& list,
                            const std::vector<std::complex<float>>& amplitude,
                            const Workers& workers, CaseReport* report);

// speckle, ray_sum_and_fft, mixing: of the array's own kind.
void time_array_stages(const Bench& bench, const ScattererList& list, CaseReport& report);

}  // namespace ensonify
