// Transmitted pulses, as spectra over the band of the record.
//
//   pulse_spectrum       S_m on the bins of a record
//   pulse_autospectrum   Fourier coefficients of |s(t)|^2, for expected power
#pragma once

#include <complex>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

// S_m for m = 0 .. M-1 at f_m = f_c + (m - M/2) b/M [M = transform], so that a unit echo at
// delay tau has the envelope s(t - tau), s(t) = sum_m S_m e^(i 2 pi (m - M/2)(b/M) t), max|s| = 1.
//   gaussian  S = exp(-(pi (f - f_c)/b)^2) T(f)     Choi et al. 2021, Eq 9; see docs/physics.md
//   flat      S = T(f)
// T is one up to |f - f_c| = 0.4 b and falls as a raised cosine to zero at 0.5 b.
std::vector<std::complex<double>> pulse_spectrum(PulseShape pulse, int transform);

// Q_k for k = 0 .. M-1: |s(t)|^2 = Q_0 + 2 Re sum_{k>=1} Q_k e^(i 2 pi k (b/M) t).
std::vector<std::complex<double>> pulse_autospectrum(
    const std::vector<std::complex<double>>& spectrum);

}  // namespace ensonify
