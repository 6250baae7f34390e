// The oracle: Eq 8-22 term by term in double precision, with no shortcut that another backend
// takes. Sums over scatterers at every frequency, mixes with the full matrix, and ends with a
// plain inverse DFT.
#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/backend.h"
#include "synthesis/draw.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

Complex unit_phasor(double turns) { return std::polar(1.0, 2.0 * kPi * turns); }

class ReferenceBackend final : public Backend {
 public:
  explicit ReferenceBackend(const SynthesisSetup& setup)
      : setup_(setup),
        mixing_(make_mixing(setup.sonar)),
        spectrum_(pulse_spectrum(setup.sonar, setup.record.transform)),
        autospectrum_(pulse_autospectrum(spectrum_)),
        source_pa_m_(source_pressure_pa_m(setup.sonar)) {}

  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    for (std::size_t i = 0; i < tasks.size(); ++i) series[i] = one_ping(tasks[i], workers);
  }

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }
  int transform() const { return setup_.record.transform; }

  PingSeries one_ping(const PingTask& task, const Workers& workers) const;
  std::vector<Complex> coherent_series(const ScattererList& list, const std::vector<Complex>& a,
                                       const Workers& workers) const;
  std::vector<double> diffuse_power(const ScattererList& list, const Workers& workers) const;
  Complex sector_spectrum(const ScattererList& list, const std::vector<Complex>& a, int beam,
                          int m) const;

  SynthesisSetup setup_;
  Mixing mixing_;
  std::vector<Complex> spectrum_, autospectrum_;
  double source_pa_m_;
};

// S0 S(f_m) sum_i a_i gain_i e^(-i 2 pi f_m tau_i) over one sector.
Complex ReferenceBackend::sector_spectrum(const ScattererList& list, const std::vector<Complex>& a,
                                          int beam, int m) const {
  const double f =
      setup_.sonar.frequency_hz + (m - transform() / 2) * setup_.sonar.bandwidth_hz / transform();
  Complex sum = 0;
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    sum += a[i] * static_cast<double>(s.gain) * unit_phasor(-carrier_turns(f, s.delay_s));
  }
  return source_pa_m_ * spectrum_[m] * sum;
}

std::vector<Complex> ReferenceBackend::coherent_series(const ScattererList& list,
                                                       const std::vector<Complex>& a,
                                                       const Workers& workers) const {
  const int bins = transform();
  std::vector<Complex> sectors(static_cast<std::size_t>(beams()) * bins);
  workers.for_each(beams(), [&](std::size_t beam) {
    for (int m = 0; m < bins; ++m) {
      sectors[beam * bins + m] = sector_spectrum(list, a, static_cast<int>(beam), m);
    }
  });
  std::vector<Complex> twiddle(bins);
  for (int m = 0; m < bins; ++m) twiddle[m] = unit_phasor(m / static_cast<double>(bins));

  std::vector<Complex> series(static_cast<std::size_t>(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t j) {
    std::vector<Complex> mixed(bins);
    for (int i = 0; i < beams(); ++i) {
      const double w = mixing_.scale[j] * mixing_.weight[std::abs(i - static_cast<int>(j))];
      for (int m = 0; m < bins; ++m) mixed[m] += w * sectors[std::size_t(i) * bins + m];
    }
    for (int n = 0; n < samples(); ++n) {
      Complex sum = 0;
      std::size_t turn = 0;  // m n mod M, so that the table serves every bin
      for (int m = 0; m < bins; ++m, turn = (turn + n) % bins) sum += mixed[m] * twiddle[turn];
      // The band starts at -M/2: e^(-i pi n).
      series[j * samples() + n] = n % 2 == 0 ? sum : -sum;
    }
  });
  return series;
}

// S0^2 sum_i (B/N_j)^2 variance gain^2 |s(t_n - tau_i)|^2, through the Fourier series of |s|^2.
std::vector<double> ReferenceBackend::diffuse_power(const ScattererList& list,
                                                    const Workers& workers) const {
  const int bins = transform();
  const double step_hz = setup_.sonar.bandwidth_hz / bins;
  std::vector<double> sectors(static_cast<std::size_t>(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t beam) {
    std::vector<Complex> coefficient(bins);
    for (int k = 0; k < bins; ++k) {
      for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
        const Scatterer& s = list.items[i];
        const double amplitude = static_cast<double>(s.standard_deviation) * s.gain;
        coefficient[k] +=
            amplitude * amplitude * unit_phasor(-carrier_turns(k * step_hz, s.delay_s));
      }
      coefficient[k] *= autospectrum_[k];
    }
    for (int n = 0; n < samples(); ++n) {
      double sum = coefficient[0].real();
      for (int k = 1; k < bins; ++k) {
        const long turn = static_cast<long>(k) * n % bins;
        sum += 2.0 * (coefficient[k] * unit_phasor(turn / static_cast<double>(bins))).real();
      }
      sectors[beam * samples() + n] = sum;
    }
  });
  std::vector<double> power(sectors.size());
  workers.for_each(beams(), [&](std::size_t j) {
    for (int i = 0; i < beams(); ++i) {
      const double w =
          source_pa_m_ * mixing_.scale[j] * mixing_.weight[std::abs(i - static_cast<int>(j))];
      for (int n = 0; n < samples(); ++n) {
        power[j * samples() + n] += w * w * sectors[std::size_t(i) * samples() + n];
      }
    }
  });
  return power;
}

PingSeries ReferenceBackend::one_ping(const PingTask& task, const Workers& workers) const {
  const ScattererList& list = *task.scatterers;
  std::vector<Complex> drawn(list.size()), mean(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    drawn[i] = Complex(draw_amplitude(list.items[i], task.keys));
    mean[i] = Complex(list.items[i].mean);
  }
  const std::vector<Complex> pressure = coherent_series(list, drawn, workers);
  const std::vector<Complex> mean_pressure = coherent_series(list, mean, workers);
  const std::vector<double> diffuse = diffuse_power(list, workers);

  PingSeries series;
  series.pressure_pa.resize(pressure.size());
  series.clean_power_pa2.resize(pressure.size());
  for (int j = 0; j < beams(); ++j) {
    for (int n = 0; n < samples(); ++n) {
      const std::size_t at = std::size_t(j) * samples() + n;
      Complex p = pressure[at];
      if (task.noise_power_pa2 > 0) p += draw_noise(task.keys, j, n, task.noise_power_pa2);
      series.pressure_pa[at] = std::complex<float>(p);
      series.clean_power_pa2[at] =
          static_cast<float>(std::max(0.0, std::norm(mean_pressure[at]) + diffuse[at]));
    }
  }
  return series;
}

}  // namespace

std::unique_ptr<Backend> make_reference_backend(const SynthesisSetup& setup) {
  return std::make_unique<ReferenceBackend>(setup);
}

}  // namespace ensonify
