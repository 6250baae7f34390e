// Synthesis in double precision throughout, with one row per beam:
//
//   series of a beam cell   deposit a gain e^(-i 2 pi f_c tau) at tau, FFT, times S(f), inverse FFT
//   power of a beam cell    deposit variance gain^2 at tau, FFT, times the spectrum of |s|^2,
//                           inverse FFT
//   volumes                 at whole samples: a plain FFT of the record in place of the deposit
//   beams                   both convolved over beams with the pattern (power: its square)
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/propagation.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/beam_mixing.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/draw.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

class DoubleSynthesis final : public PingSynthesis {
 public:
  explicit DoubleSynthesis(const SynthesisTables& tables)
      : setup_(tables.setup),
        stride_((transform() + 3) / 4 * 4),
        source_pa_m_(source_pressure_pa_m(setup_.sonar)),
        spectrum_(tables.spectrum),
        autospectrum_(tables.autospectrum),
        series_kernel_(make_gridding_kernel(2 * transform(), transform() / 2)),
        power_kernel_(make_gridding_kernel(4 * transform(), transform())),
        series_forward_(series_kernel_.grid, FftDirection::forward),
        series_backward_(transform(), FftDirection::backward),
        power_forward_(power_kernel_.grid, FftDirection::forward),
        power_backward_(transform(), FftDirection::backward),
        volume_forward_(transform(), FftDirection::forward),
        volume_power_forward_(transform(), FftDirection::forward),
        mixer_(tables.mixing) {}

  SynthesisMemory memory(bool has_volumes) const override;
  void run(const PingTask& task, PingSeries& series, const Workers& workers) const override;

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }
  int transform() const { return setup_.record.transform; }
  double position(double delay_s) const {
    return delay_s * setup_.sonar.bandwidth_hz / transform();
  }

  bool has_scatterers(const PingTask& task, std::size_t beam) const {
    return task.scatterers->beam_offset[beam] != task.scatterers->beam_offset[beam + 1];
  }

  AlignedBuffer<Complex> series(const PingTask& task, EchoAmplitude which,
                                const Workers& workers) const;
  AlignedBuffer<double> diffuse_power(const PingTask& task, const Workers& workers) const;
  void scatterer_spectrum(const PingTask& task, EchoAmplitude which, int beam, Complex* row) const;
  void add_volume_spectrum(const PingTask& task, int beam, Complex* row) const;
  void scatterer_power(const PingTask& task, int beam, Complex* folded) const;
  void add_volume_power(const PingTask& task, int beam, Complex* folded) const;
  void clean_power(const PingTask& task, PingSeries& result, const Workers& workers) const;

  SynthesisSetup setup_;
  int stride_;  // numbers from row to row; rows begin on 64-byte boundaries
  double source_pa_m_;
  std::vector<Complex> spectrum_, autospectrum_;
  GriddingKernel series_kernel_, power_kernel_;
  ComplexFft series_forward_, series_backward_;
  RealFft power_forward_, power_backward_;
  ComplexFft volume_forward_;
  RealFft volume_power_forward_;
  BeamMixer mixer_;
};

// Writes the transform() bins of one ideal beam cell, f_c first.
void DoubleSynthesis::scatterer_spectrum(const PingTask& task, EchoAmplitude which, int beam,
                                         Complex* row) const {
  const ScattererList& list = *task.scatterers;
  AlignedBuffer<Complex> grid(series_kernel_.grid);
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const std::complex<float> a =
        which == EchoAmplitude::drawn ? draw_amplitude(s, task.keys) : s.mean;
    const double turns = carrier_turns(setup_.sonar.frequency_hz, s.delay_s);
    const Complex echo =
        Complex(a) * static_cast<double>(s.gain) * std::polar(source_pa_m_, -2.0 * kPi * turns);
    spread(series_kernel_, position(s.delay_s), echo, grid.data());
  }
  series_forward_.run(grid.data());
  // Bin m of the band is k = m - M/2. The inverse transform needs k = 0 first.
  const int half = transform() / 2;
  for (int k = -half; k < half; ++k) {
    const int source = k < 0 ? k + series_kernel_.grid : k;
    const int target = k < 0 ? k + transform() : k;
    row[target] = spectrum_[k + half] * series_kernel_.correction[std::abs(k)] * grid[source];
  }
}

void DoubleSynthesis::add_volume_spectrum(const PingTask& task, int beam, Complex* row) const {
  AlignedBuffer<Complex> cells(transform());
  for (int n = 0; n < samples(); ++n) {
    const double energy = total_energy(task.volumes, std::size_t(beam) * samples() + n);
    cells[n] = source_pa_m_ * draw_volume(task.keys, beam, n, energy);
  }
  volume_forward_.run(cells.data());
  const int half = transform() / 2;
  for (int bin = 0; bin < transform(); ++bin) {
    row[bin] += spectrum_[bin < half ? bin + half : bin - half] * cells[bin];
  }
}

AlignedBuffer<Complex> DoubleSynthesis::series(const PingTask& task, EchoAmplitude which,
                                               const Workers& workers) const {
  AlignedBuffer<Complex> rows(std::size_t(beams()) * stride_);
  const bool has_volumes = which == EchoAmplitude::drawn && !task.volumes.empty();
  workers.for_each(beams(), [&](std::size_t beam) {
    const bool heard = has_scatterers(task, beam);
    if (!heard && !has_volumes) return;
    Complex* row = rows.data() + beam * stride_;
    if (heard) scatterer_spectrum(task, which, static_cast<int>(beam), row);
    if (has_volumes) add_volume_spectrum(task, static_cast<int>(beam), row);
    series_backward_.run(row);
  });
  mixer_.mix_amplitude(rows.data(), samples(), stride_, workers);
  return rows;
}

// Writes the Fourier coefficients k = 0 .. M/2 of one ideal beam cell's power at the samples.
void DoubleSynthesis::scatterer_power(const PingTask& task, int beam, Complex* folded) const {
  const ScattererList& list = *task.scatterers;
  AlignedBuffer<double> grid(power_kernel_.grid);
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const double amplitude = source_pa_m_ * s.standard_deviation * s.gain;
    spread(power_kernel_, position(s.delay_s), amplitude * amplitude, grid.data());
  }
  AlignedBuffer<Complex> half(power_kernel_.grid / 2 + 1);
  power_forward_.run(grid.data(), half.data());
  // |s|^2 has twice the bandwidth of s. At sampling steps of 1/b, its upper half folds onto the
  // lower half.
  const int bins = transform();
  const auto term = [&](int k) {
    return k < bins ? autospectrum_[k] * power_kernel_.correction[k] * half[k] : Complex(0);
  };
  for (int k = 0; k <= bins / 2; ++k) folded[k] = term(k) + std::conj(term(bins - k));
}

void DoubleSynthesis::add_volume_power(const PingTask& task, int beam, Complex* folded) const {
  const int bins = transform();
  AlignedBuffer<double> cells(bins);
  for (int n = 0; n < samples(); ++n) {
    cells[n] =
        source_pa_m_ * source_pa_m_ * total_energy(task.volumes, std::size_t(beam) * samples() + n);
  }
  AlignedBuffer<Complex> half(bins / 2 + 1);
  volume_power_forward_.run(cells.data(), half.data());
  // The spectrum of whole samples has the period M, so that both folded bins have the same value.
  folded[0] += autospectrum_[0] * half[0];
  for (int k = 1; k <= bins / 2; ++k) {
    folded[k] += (autospectrum_[k] + std::conj(autospectrum_[bins - k])) * half[k];
  }
}

AlignedBuffer<double> DoubleSynthesis::diffuse_power(const PingTask& task,
                                                     const Workers& workers) const {
  const std::size_t stride = (transform() + 7) / 8 * 8;
  AlignedBuffer<double> rows(beams() * stride);
  const bool has_volumes = !task.volumes.empty();
  workers.for_each(beams(), [&](std::size_t beam) {
    const bool heard = has_scatterers(task, beam);
    if (!heard && !has_volumes) return;
    AlignedBuffer<Complex> folded(transform() / 2 + 1);
    if (heard) scatterer_power(task, static_cast<int>(beam), folded.data());
    if (has_volumes) add_volume_power(task, static_cast<int>(beam), folded.data());
    power_backward_.run(rows.data() + beam * stride, folded.data());
  });
  mixer_.mix_power(rows.data(), samples(), static_cast<int>(stride), workers);
  return rows;
}

SynthesisMemory DoubleSynthesis::memory(bool) const {
  const std::uint64_t row = transform();
  SynthesisMemory memory;
  memory.shared_bytes = 8 * row * sizeof(Complex) + mixer_.matrix_bytes();
  // A ping: series, mean and power of all beams. A thread: the grid of powers and its spectrum.
  memory.ping_bytes = beams() * row * (2 * sizeof(Complex) + sizeof(double));
  memory.thread_bytes = 5 * row * sizeof(Complex);
  return memory;
}

void DoubleSynthesis::run(const PingTask& task, PingSeries& result, const Workers& workers) const {
  result.pressure_pa.resize(std::size_t(beams()) * samples());
  const AlignedBuffer<Complex> drawn = series(task, EchoAmplitude::drawn, workers);
  workers.for_each(beams(), [&](std::size_t j) {
    for (int n = 0; n < samples(); ++n) {
      Complex p = drawn[j * stride_ + n];
      if (task.noise_power_pa2 > 0) {
        p += draw_noise(task.keys, static_cast<int>(j), n, task.noise_power_pa2);
      }
      result.pressure_pa[j * samples() + n] = std::complex<float>(p);
    }
  });
  if (task.wants_clean) {
    clean_power(task, result, workers);
  } else {
    result.clean_power_pa2.clear();
  }
}

void DoubleSynthesis::clean_power(const PingTask& task, PingSeries& result,
                                  const Workers& workers) const {
  result.clean_power_pa2.resize(std::size_t(beams()) * samples());
  const AlignedBuffer<double> diffuse = diffuse_power(task, workers);
  const std::size_t diffuse_stride = diffuse.size() / beams();
  const bool has_mean = has_means(task);
  const AlignedBuffer<Complex> mean =
      has_mean ? series(task, EchoAmplitude::mean, workers) : AlignedBuffer<Complex>(0);
  workers.for_each(beams(), [&](std::size_t j) {
    for (int n = 0; n < samples(); ++n) {
      const double coherent = has_mean ? std::norm(mean[j * stride_ + n]) : 0.0;
      // Rounding in the transforms can make samples without echoes negative.
      const double power = std::max(0.0, diffuse[j * diffuse_stride + n] + coherent);
      result.clean_power_pa2[j * samples() + n] = static_cast<float>(power);
    }
  });
}

}  // namespace

std::unique_ptr<PingSynthesis> make_double_synthesis(const SynthesisTables& tables) {
  return std::make_unique<DoubleSynthesis>(tables);
}

}  // namespace ensonify
