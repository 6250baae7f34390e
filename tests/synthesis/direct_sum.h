// Mean and covariance of the series worked out in the time domain, echo by echo: a route of its own
// beside the backends, which work in frequency.
#pragma once

#include <cmath>
#include <complex>
#include <cstdlib>
#include <span>
#include <vector>

#include "acoustics/pulse.h"
#include "core/scatterers.h"
#include "core/units.h"
#include "synthesis/backend.h"

namespace ensonify::test {

// For sonars with uniform shading and N_j = 1.
class DirectSum {
 public:
  using Complex = std::complex<double>;

  explicit DirectSum(const SynthesisSetup& setup)
      : setup_(setup), spectrum_(pulse_spectrum(setup.sonar, setup.record.transform)) {}

  // s(t), t in samples.
  Complex pulse(double t) const {
    const int bins = setup_.record.transform;
    Complex sum = 0;
    for (int m = 0; m < bins; ++m) {
      sum += spectrum_[m] * std::polar(1.0, 2 * kPi * (m - bins / 2) * t / bins);
    }
    return sum;
  }

  double pattern(int i, int j) const {
    const double u = 0.884 * std::sin((i - j) * setup_.sonar.beam_spacing_rad) /
                     setup_.sonar.beam_width_rad * kPi;
    return i == j ? 1 : std::sin(u) / u;
  }

  // E p_j(t_n).
  Complex mean(const ScattererList& list, int j, int n) const {
    Complex sum = 0;
    for (const Scatterer& s : list.items) {
      const double turns = std::fmod(setup_.sonar.frequency_hz * s.delay_s, 1.0);
      sum += source() * pattern(s.beam, j) * s.gain * Complex(s.mean) *
             std::polar(1.0, -2 * kPi * turns) * pulse(n - s.delay_s * setup_.sonar.bandwidth_hz);
    }
    return sum;
  }

  // E (p_j(t_n) - E p_j(t_n)) (p_k(t_m) - E p_k(t_m))*.
  Complex covariance(const ScattererList& list, std::span<const VolumeEcho> volumes, int j, int n,
                     int k, int m) const {
    Complex sum = 0;
    const auto add = [&](int beam, double delay, double variance) {
      sum += variance * pattern(beam, j) * pattern(beam, k) * pulse(n - delay) *
             std::conj(pulse(m - delay));
    };
    for (const Scatterer& s : list.items) {
      const double rms = static_cast<double>(s.standard_deviation) * s.gain;
      add(static_cast<int>(s.beam), s.delay_s * setup_.sonar.bandwidth_hz, rms * rms);
    }
    for (const VolumeEcho& volume : volumes) {
      for (std::size_t cell = 0; cell < volume.energy.size(); ++cell) {
        const int samples = setup_.record.samples;
        if (volume.energy[cell] == 0) continue;
        add(static_cast<int>(cell) / samples, static_cast<int>(cell) % samples,
            volume.energy[cell]);
      }
    }
    return source() * source() * sum;
  }

 private:
  double source() const { return std::pow(10.0, (setup_.sonar.source_level_db - 120) / 20); }

  SynthesisSetup setup_;
  std::vector<Complex> spectrum_;
};

}  // namespace ensonify::test
