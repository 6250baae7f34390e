#include "acoustics/pulse.h"

#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

// x = (f - f_c)/b.
double edge_taper(double x) {
  const double distance = std::abs(x);
  if (distance <= 0.4) return 1;
  if (distance >= 0.5) return 0;
  return 0.5 * (1 + std::cos(kPi * (distance - 0.4) / 0.1));
}

double shape(const Pulse& pulse, double x) {
  return pulse.shape == PulseShape::gaussian ? std::exp(-(kPi * x) * (kPi * x)) : 1;
}

}  // namespace

std::vector<std::complex<double>> pulse_spectrum(const Sonar& sonar, int transform) {
  ENSONIFY_ASSERT(transform >= 2 && transform % 2 == 0);
  std::vector<std::complex<double>> spectrum(transform);
  double peak = 0;  // all bins are real and positive, so they add up in phase at t = 0
  for (int m = 0; m < transform; ++m) {
    const double x = (m - transform / 2) / static_cast<double>(transform);
    spectrum[m] = shape(sonar.pulse, x) * edge_taper(x);
    peak += spectrum[m].real();
  }
  for (auto& bin : spectrum) bin /= peak;
  return spectrum;
}

double pulse_extent_s(const Sonar& sonar) {
  return sonar.pulse.shape == PulseShape::cw ? sonar.pulse.duration_s : 0;
}

double processing_gain(const Sonar& sonar) {
  return sonar.pulse.shape == PulseShape::lfm ? sonar.bandwidth_hz * sonar.pulse.duration_s : 1;
}

std::vector<std::complex<double>> pulse_autospectrum(
    const std::vector<std::complex<double>>& spectrum) {
  const std::size_t count = spectrum.size();
  std::vector<std::complex<double>> autospectrum(count);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t m = 0; m + k < count; ++m) {
      autospectrum[k] += spectrum[m + k] * std::conj(spectrum[m]);
    }
  }
  return autospectrum;
}

}  // namespace ensonify
