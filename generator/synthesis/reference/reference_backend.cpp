// The reference: Choi et al. 2021, Eq 8-22, term by term in double precision, without the shortcuts
// of the other backends. It sums scatterers at every frequency, mixes beams with the full matrix,
// and ends with a plain inverse DFT.
#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/adc.h"
#include "synthesis/backend.h"
#include "synthesis/beamforming.h"
#include "synthesis/draw.h"
#include "synthesis/reference/array_reference.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// The terms of one ping's sums: the scatterers with their amplitudes, and the cells of volumes.
struct Echoes {
  const ScattererList& list;
  std::vector<Complex> scatterer;  // [list]
  std::vector<Complex> cell;       // [beams x samples]; empty without volumes
};

Complex unit_phasor(double turns) { return std::polar(1.0, 2.0 * kPi * turns); }

class ReferenceBackend final : public Backend {
 public:
  explicit ReferenceBackend(const SynthesisSetup& setup)
      : setup_(setup),
        mixing_(make_mixing(setup.sonar)),
        spectrum_(pulse_spectrum(setup.sonar, setup.record.transform)),
        shifted_(make_doppler_pulse(setup.sonar, setup.record.transform)),
        autospectrum_(pulse_autospectrum(spectrum_)),
        source_pa_m_(source_pressure_pa_m(setup.sonar)) {}

  SynthesisMemory memory(bool) const override {
    const std::uint64_t row = transform();
    return {3 * row * sizeof(Complex) + mixing_.matrix.size() * sizeof(double),
            beams() * row * (2 * sizeof(Complex) + sizeof(double)),
            sizeof(Scatterer) + sizeof(Complex), row * sizeof(Complex)};
  }

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
  Echoes drawn_echoes(const PingTask& task) const;
  SampleArray<float> clean_power(const PingTask& task, const Workers& workers) const;
  std::vector<Complex> coherent_series(const Echoes& echoes, const Workers& workers) const;
  std::vector<double> diffuse_power(const PingTask& task, const Workers& workers) const;
  Complex sector_spectrum(const Echoes& echoes, int beam, int m) const;
  Complex diffuse_coefficient(const PingTask& task, int beam, int k) const;

  SynthesisSetup setup_;
  Mixing mixing_;
  std::vector<Complex> spectrum_;
  DopplerPulse shifted_;
  std::vector<Complex> autospectrum_;
  double source_pa_m_;
};

// S0 S(f_m) (sum_i a_i gain_i e^(-i 2 pi f_m tau_i) + sum_n v_n e^(-i 2 pi (f_m - f_c) t_n)) over
// one beam cell. An echo i with Doppler eta has S_eta in place of S. The v_n of volumes are
// circular, so that they need no carrier phase.
Complex ReferenceBackend::sector_spectrum(const Echoes& echoes, int beam, int m) const {
  const ScattererList& list = echoes.list;
  const int k = m - transform() / 2;
  const double f = setup_.sonar.frequency_hz + k * setup_.sonar.bandwidth_hz / transform();
  Complex sum = 0, shifted = 0;
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const Complex echo = echoes.scatterer[i] * static_cast<double>(s.gain) *
                         unit_phasor(-carrier_turns(f, s.delay_s));
    if (s.doppler == 0) {
      sum += echo;
    } else {
      shifted += echo * doppler_bin(shifted_, static_cast<double>(s.doppler), m);
    }
  }
  if (!echoes.cell.empty()) {
    for (int n = 0; n < samples(); ++n) {
      const long turn = static_cast<long>(k) * n % transform();
      sum += echoes.cell[std::size_t(beam) * samples() + n] *
             unit_phasor(-turn / static_cast<double>(transform()));
    }
  }
  return source_pa_m_ * spectrum_[m] * sum + source_pa_m_ * shifted;
}

std::vector<Complex> ReferenceBackend::coherent_series(const Echoes& echoes,
                                                       const Workers& workers) const {
  const int bins = transform();
  std::vector<Complex> sectors(static_cast<std::size_t>(beams()) * bins);
  workers.for_each(beams(), [&](std::size_t beam) {
    for (int m = 0; m < bins; ++m) {
      sectors[beam * bins + m] = sector_spectrum(echoes, static_cast<int>(beam), m);
    }
  });
  std::vector<Complex> twiddle(bins);
  for (int m = 0; m < bins; ++m) twiddle[m] = unit_phasor(m / static_cast<double>(bins));

  std::vector<Complex> series(static_cast<std::size_t>(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t j) {
    std::vector<Complex> mixed(bins);
    for (int i = 0; i < beams(); ++i) {
      const double w = mixing_.scale[j] * mixing_.at(static_cast<int>(j), i);
      for (int m = 0; m < bins; ++m) mixed[m] += w * sectors[std::size_t(i) * bins + m];
    }
    for (int n = 0; n < samples(); ++n) {
      Complex sum = 0;
      std::size_t turn = 0;  // m n mod M, so that the table serves every bin
      for (int m = 0; m < bins; ++m, turn = (turn + n) % bins) sum += mixed[m] * twiddle[turn];
      // The band starts at -M/2, hence the factor e^(-i pi n).
      series[j * samples() + n] = n % 2 == 0 ? sum : -sum;
    }
  });
  return series;
}

// Q_k (sum_i variance gain^2 e^(-i 2 pi k (b/M) tau_i) + sum_n E_n e^(-i 2 pi k n/M)) over one beam
// cell, with Q the Fourier coefficients of |s|^2 and E_n the energies of volumes.
Complex ReferenceBackend::diffuse_coefficient(const PingTask& task, int beam, int k) const {
  const ScattererList& list = *task.scatterers;
  const double frequency_hz = k * setup_.sonar.bandwidth_hz / transform();
  Complex sum = 0;
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const double amplitude = static_cast<double>(s.standard_deviation) * s.gain;
    sum += amplitude * amplitude * unit_phasor(-carrier_turns(frequency_hz, s.delay_s));
  }
  if (!task.volumes.empty()) {
    for (int n = 0; n < samples(); ++n) {
      const long turn = static_cast<long>(k) * n % transform();
      sum += total_energy(task.volumes, std::size_t(beam) * samples() + n) *
             unit_phasor(-turn / static_cast<double>(transform()));
    }
  }
  return autospectrum_[k] * sum;
}

// S0^2 sum_i (B/N_j)^2 variance gain^2 |s(t_n - tau_i)|^2, and the same for volumes, by the Fourier
// series of |s|^2.
std::vector<double> ReferenceBackend::diffuse_power(const PingTask& task,
                                                    const Workers& workers) const {
  const int bins = transform();
  std::vector<double> sectors(static_cast<std::size_t>(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t beam) {
    std::vector<Complex> coefficient(bins);
    for (int k = 0; k < bins; ++k) {
      coefficient[k] = diffuse_coefficient(task, static_cast<int>(beam), k);
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
      const double w = source_pa_m_ * mixing_.scale[j] * mixing_.at(static_cast<int>(j), i);
      for (int n = 0; n < samples(); ++n) {
        power[j * samples() + n] += w * w * sectors[std::size_t(i) * samples() + n];
      }
    }
  });
  return power;
}

Echoes ReferenceBackend::drawn_echoes(const PingTask& task) const {
  Echoes echoes{*task.scatterers, {}, {}};
  for (const Scatterer& s : echoes.list.items) {
    echoes.scatterer.emplace_back(draw_amplitude(s, task.keys));
  }
  if (task.volumes.empty()) return echoes;
  for (int beam = 0; beam < beams(); ++beam) {
    for (int n = 0; n < samples(); ++n) {
      const double energy = total_energy(task.volumes, echoes.cell.size());
      echoes.cell.push_back(draw_volume(task.keys, beam, n, energy));
    }
  }
  return echoes;
}

PingSeries ReferenceBackend::one_ping(const PingTask& task, const Workers& workers) const {
  for (const VolumeEcho& volume : task.volumes) {
    ENSONIFY_ASSERT(volume.energy.size() == std::size_t(beams()) * samples());
  }
  const std::vector<Complex> pressure = coherent_series(drawn_echoes(task), workers);
  PingSeries series;
  series.pressure_pa.resize(pressure.size());
  for (int j = 0; j < beams(); ++j) {
    for (int n = 0; n < samples(); ++n) {
      const std::size_t at = std::size_t(j) * samples() + n;
      Complex p = pressure[at];
      if (task.noise_power_pa2 > 0) p += draw_noise(task.keys, j, n, task.noise_power_pa2);
      series.pressure_pa[at] = std::complex<float>(p);
    }
  }
  if (task.converts && setup_.sonar.adc) quantise(*setup_.sonar.adc, series.pressure_pa);
  if (task.wants_clean) series.clean_power_pa2 = clean_power(task, workers);
  return series;
}

SampleArray<float> ReferenceBackend::clean_power(const PingTask& task,
                                                 const Workers& workers) const {
  Echoes means{*task.scatterers, {}, {}};
  for (const Scatterer& s : means.list.items) means.scatterer.emplace_back(s.mean);
  const std::vector<Complex> mean_pressure = coherent_series(means, workers);
  const std::vector<double> diffuse = diffuse_power(task, workers);
  SampleArray<float> power;
  for (std::size_t i = 0; i < diffuse.size(); ++i) {
    power.push_back(static_cast<float>(std::max(0.0, std::norm(mean_pressure[i]) + diffuse[i])));
  }
  return power;
}

}  // namespace

std::unique_ptr<Backend> make_reference_backend(const SynthesisSetup& setup) {
  if (setup.sonar.array) return make_array_reference_backend(setup);
  return std::make_unique<ReferenceBackend>(setup);
}

}  // namespace ensonify
