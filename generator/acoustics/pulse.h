// Transmitted pulses, as spectra over the band of the record.
//
//   pulse_spectrum       S_m on the bins of a record
//   pulse_is_heard       whether any of its spectrum falls on a bin
//   pulse_extent_s       T_p, by which a record is longer than its echoes
//   pulse_width_s        -3 dB width
//   echo_step_samples    the spacing of echoes that add up to an even level
//   processing_gain      by which its matched filter lowers the noise
//   pulse_autospectrum   Fourier coefficients of |s(t)|^2, for expected power
//   DopplerPulse  make_doppler_pulse   the pulse of echoes with Doppler
//   doppler_bin  doppler_spectrum      S_m of one of them
//   envelope_squared     the envelope of a pulse between the samples, without a transform library
#pragma once

#include <complex>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

// S_m for m = 0 .. M-1 at f_m = f_c + (m - M/2) b/M [M = transform], so that a unit echo at
// delay tau has the envelope s(t - tau), s(t) = sum_m S_m e^(i 2 pi (m - M/2)(b/M) t), max|s| = 1.
//   gaussian  S = exp(-(pi (f - f_c)/b)^2) T(f)     Choi et al. 2021, Eq 9; see
//             docs/physics/2_pulse_and_record.md
//   flat      S = T(f)
//   lfm       S = T(f) with `taper` in place of a tenth: the compressed chirp
//   cw        S = sinc((f - f_c) duration) T(f): a tone burst
//   table     S = A(f) e^(i phi(f)) T(f), both interpolated linearly in f (phi unwrapped first),
//             zero outside the table: its peak comes at its group delay
// T is one up to |f - f_c| = 0.4 b and falls as a raised cosine to zero at 0.5 b. Then S is
// multiplied by the receiver's window W(x), x = (f - f_c)/b: hann (1 + cos 2 pi x)/2, hamming 0.54
// + 0.46 cos 2 pi x, blackman 0.42 + 0.5 cos 2 pi x + 0.08 cos 4 pi x. Finally S is scaled so that
// max|s| = 1 over the grid t = k / (32 b), k = 0 .. 32 M - 1. A table needs two rows, and some
// amplitude on a bin of the band (pulse_is_heard).
std::vector<std::complex<double>> pulse_spectrum(const Sonar& sonar, int transform);

// Whether S differs from 0 on any bin: the band of a table may lie between two bins.
bool pulse_is_heard(const Sonar& sonar, int transform);

// T_p, by which a record is longer than its echoes. For cw it is the duration. For a table, and for
// an lfm whose taper is below a tenth, it is the shortest interval that contains t = 0 and all
// |s(t)| above -90 dB of the peak, searched at t = k / (8b) and rounded outward to that grid
// (65,536 samples at most). For others it is 0.
double pulse_extent_s(const Sonar& sonar);

// The -3 dB width of |s(t)|^2 around its peak, searched at t = k / (32 b) and interpolated.
double pulse_width_s(const Sonar& sonar, int transform);

// The longest delay between equally spaced echoes, in samples 1/b, at which the rms ripple of their
// summed power |s(t)|^2 stays within `level_db`: sqrt(2) |Q_k| / Q_0 at all frequencies k from the
// reciprocal of that delay on. From 1, as |s(t)|^2 has no spectrum beyond b, to 1.5.
double echo_step_samples(const Sonar& sonar, int transform, double level_db);

// b duration for lfm, 1 for others. The noise power is divided by it.
double processing_gain(const Sonar& sonar);

// Q_k for k = 0 .. M-1: |s(t)|^2 = Q_0 + 2 Re sum_{k>=1} Q_k e^(i 2 pi k (b/M) t).
std::vector<std::complex<double>> pulse_autospectrum(
    const std::vector<std::complex<double>>& spectrum);

// S = P W T: the transmitted pulse P (gaussian: exp(..), cw: sinc(..), table: A e^(i phi), flat and
// lfm: 1) after the receiver's window and the edges of its band. An echo with Doppler eta > -1 is
// the pulse e^(i 2 pi f_c eta (t - tau)) P((1 + eta)(t - tau)) after the same receiver:
//   S_eta(f) = P(f') W(f - f_c) T(f - f_c) / (1 + eta),  f' = (f - f_c - eta f_c)/(1 + eta)
// scaled as S is. Spectrum that Doppler moves out of the band is lost. doppler 0 gives
// pulse_spectrum.
struct DopplerPulse {
  Sonar sonar;
  int transform = 0;
  std::vector<PulseTableRow> table;  // of table: phases unwrapped
  double peak = 1;                   // divisor of pulse_spectrum
};
DopplerPulse make_doppler_pulse(const Sonar& sonar, int transform);

// S_m of bin m in [0, transform).
std::complex<double> doppler_bin(const DopplerPulse& pulse, double doppler, int m);
std::vector<std::complex<double>> doppler_spectrum(const DopplerPulse& pulse, double doppler);

// |s(t)|^2 of s(t) = sum_m S_m e^(i 2 pi (m - M/2)(b/M) t) at t = k / (oversampling b),
// k = 0 .. oversampling M - 1. Fast if the number of bins, M, has only small prime factors.
std::vector<double> envelope_squared(const std::vector<std::complex<double>>& spectrum,
                                     int oversampling);

}  // namespace ensonify
