#include <algorithm>
#include <cmath>

#include "acoustics/propagation.h"
#include "core/units.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/array_power.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/draw.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;
using Spectra = AlignedBuffer<Complex>;  // [elements][stride], k = 0 first

class DoubleArraySynthesis final : public PingSynthesis {
 public:
  explicit DoubleArraySynthesis(const SynthesisTables& tables)
      : setup_(tables.setup),
        geometry_(make_array_geometry(setup_.sonar)),
        spectrum_(tables.spectrum),
        source_pa_m_(source_pressure_pa_m(setup_.sonar)),
        stride_((bins() + 3) / 4 * 4),
        kernel_(make_gridding_kernel(2 * bins(), bins() / 2)),
        grid_forward_(kernel_.grid, FftDirection::forward),
        forward_(bins(), FftDirection::forward),
        backward_(bins(), FftDirection::backward),
        power_(make_array_power(tables)) {}

  SynthesisMemory memory(bool) const override;
  void run(const PingTask& task, PingSeries& series, const Workers& workers) const override;

 private:
  int elements() const { return static_cast<int>(geometry_.y_m.size()); }
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }
  int bins() const { return setup_.record.transform; }
  double carrier_hz() const { return setup_.sonar.frequency_hz; }
  double speed_m_s() const { return setup_.water.sound_speed_m_s; }

  void deposit(Vec3 apparent_m, double u, double delay_s, double turns, Complex amplitude,
               int element, Complex* grid) const;
  void deposit_cells(const PingTask& task, int element, Complex* grid) const;
  void element_spectrum(const PingTask& task, EchoAmplitude which, int element, Complex* row) const;
  Spectra spectra(const PingTask& task, EchoAmplitude which, const Workers& workers) const;
  void beam(const Spectra& spectra, int j, Complex* record, Complex* sum) const;
  template <class Write>
  void beams(const Spectra& spectra, const Workers& workers, Write&& write) const;

  SynthesisSetup setup_;
  ArrayGeometry geometry_;
  std::vector<Complex> spectrum_;
  double source_pa_m_;
  int stride_;
  GriddingKernel kernel_;
  ComplexFft grid_forward_, forward_, backward_;
  std::unique_ptr<const ArrayPower> power_;
};

void DoubleArraySynthesis::deposit(Vec3 apparent_m, double u, double delay_s, double turns,
                                   Complex amplitude, int element, Complex* grid) const {
  const double later = element_delay_s(apparent_m, geometry_.y_m[element], speed_m_s());
  const double heard =
      element_pattern(u, setup_.sonar.array->element_width_m, speed_m_s() / carrier_hz());
  const Complex echo =
      geometry_.response[element] * amplitude *
      std::polar(source_pa_m_ * heard, -2 * kPi * (turns + carrier_turns(carrier_hz(), later)));
  spread(kernel_, (delay_s + later) * setup_.sonar.bandwidth_hz / bins(), echo, grid);
}

void DoubleArraySynthesis::deposit_cells(const PingTask& task, int element, Complex* grid) const {
  for (int j = 0; j < beams(); ++j) {
    const double azimuth = beam_azimuth_rad(setup_.sonar, j);
    for (int n = 0; n < samples(); ++n) {
      const double energy = total_energy(task.volumes, std::size_t(j) * samples() + n);
      if (energy == 0) continue;
      const double range_m = focus_range_m(setup_.sonar, setup_.water, n);
      deposit(range_m * unit_vector(azimuth, 0), std::sin(azimuth), n / setup_.sonar.bandwidth_hz,
              0, draw_volume(task.keys, j, n, energy), element, grid);
    }
  }
}

void DoubleArraySynthesis::element_spectrum(const PingTask& task, EchoAmplitude which, int element,
                                            Complex* row) const {
  AlignedBuffer<Complex> grid(kernel_.grid);
  for (const Scatterer& s : task.scatterers->items) {
    const std::complex<float> a =
        which == EchoAmplitude::drawn ? draw_amplitude(s, task.keys) : s.mean;
    deposit(apparent_point_m(s), unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad).y,
            s.delay_s, carrier_turns(carrier_hz(), s.delay_s),
            Complex(a) * static_cast<double>(s.gain), element, grid.data());
  }
  if (which == EchoAmplitude::drawn && !task.volumes.empty()) {
    deposit_cells(task, element, grid.data());
  }
  grid_forward_.run(grid.data());
  const int half = bins() / 2;
  for (int k = -half; k < half; ++k) {
    row[k < 0 ? k + bins() : k] =
        spectrum_[k + half] * kernel_.correction[std::abs(k)] * grid[k < 0 ? k + kernel_.grid : k];
  }
  if (which == EchoAmplitude::mean || task.noise_power_pa2 == 0) return;
  if (geometry_.response[element] == Complex(0)) return;
  const double power = element_noise_power_pa2(geometry_, task.noise_power_pa2);
  AlignedBuffer<Complex> noise(bins());
  for (int n = 0; n < bins(); ++n) noise[n] = draw_noise(task.keys, element, n, power);
  forward_.run(noise.data());
  for (int k = 0; k < bins(); ++k) row[k] += noise[k] / static_cast<double>(bins());
}

Spectra DoubleArraySynthesis::spectra(const PingTask& task, EchoAmplitude which,
                                      const Workers& workers) const {
  Spectra rows(std::size_t(elements()) * stride_);
  workers.for_each(elements(), [&](std::size_t n) {
    element_spectrum(task, which, static_cast<int>(n), rows.data() + n * stride_);
  });
  return rows;
}

void DoubleArraySynthesis::beam(const Spectra& spectra, int j, Complex* record,
                                Complex* sum) const {
  const ArrayReceiver& array = *setup_.sonar.array;
  const double azimuth = beam_azimuth_rad(setup_.sonar, j);
  const double bin_hz = setup_.sonar.bandwidth_hz / bins();
  std::fill_n(sum, samples(), Complex(0));
  for (int element = 0; element < elements(); ++element) {
    const double y = geometry_.y_m[element];
    const double later = steering_delay_s(y, azimuth, speed_m_s());
    const Complex* row = spectra.data() + std::size_t(element) * stride_;
    for (int bin = 0; bin < bins(); ++bin) {
      const int k = bin < bins() / 2 ? bin : bin - bins();
      const bool delayed = array.steering == Steering::true_delay;
      record[bin] = delayed ? row[bin] * std::polar(1.0, 2 * kPi * k * bin_hz * later) : row[bin];
    }
    backward_.run(record);
    for (int n = 0; n < samples(); ++n) {
      double turns = carrier_hz() * later;
      if (array.focus == Focus::dynamic) {
        const double range_m = focus_range_m(setup_.sonar, setup_.water, n);
        turns += carrier_hz() * focus_delay_s(y, azimuth, range_m, speed_m_s());
      }
      sum[n] += std::polar(geometry_.weight[element], 2 * kPi * turns) * record[n];
    }
  }
}

template <class Write>
void DoubleArraySynthesis::beams(const Spectra& spectra, const Workers& workers,
                                 Write&& write) const {
  workers.for_each(beams(), [&](std::size_t j) {
    AlignedBuffer<Complex> record(bins()), sum(samples());
    beam(spectra, static_cast<int>(j), record.data(), sum.data());
    for (int n = 0; n < samples(); ++n) write(j * samples() + n, sum[n]);
  });
}

SynthesisMemory DoubleArraySynthesis::memory(bool) const {
  const std::uint64_t row = stride_ * sizeof(Complex);
  SynthesisMemory memory;
  memory.shared_bytes = 8 * row;
  memory.ping_bytes = 2 * elements() * row;
  memory.thread_bytes = 4 * row;
  const SynthesisMemory power = power_->memory();
  memory.shared_bytes += power.shared_bytes;
  memory.ping_bytes += power.ping_bytes;
  memory.thread_bytes += power.thread_bytes;
  return memory;
}

void DoubleArraySynthesis::run(const PingTask& task, PingSeries& result,
                               const Workers& workers) const {
  result.pressure_pa.resize(std::size_t(beams()) * samples());
  result.channels_pa.resize(task.wants_channels ? std::size_t(elements()) * samples() : 0);
  const Spectra drawn = spectra(task, EchoAmplitude::drawn, workers);
  beams(drawn, workers,
        [&](std::size_t at, Complex p) { result.pressure_pa[at] = std::complex<float>(p); });
  if (task.wants_channels) {
    workers.for_each(elements(), [&](std::size_t n) {
      AlignedBuffer<Complex> record(bins());
      std::copy_n(drawn.data() + n * stride_, bins(), record.data());
      backward_.run(record.data());
      for (int t = 0; t < samples(); ++t) {
        result.channels_pa[n * samples() + t] = std::complex<float>(record[t]);
      }
    });
  }
  result.clean_power_pa2.clear();
  if (!task.wants_clean) return;
  power_->diffuse(task, result.clean_power_pa2, workers);
  if (!has_means(task)) return;
  beams(spectra(task, EchoAmplitude::mean, workers), workers, [&](std::size_t at, Complex p) {
    result.clean_power_pa2[at] += static_cast<float>(std::norm(p));
  });
}

}  // namespace

std::unique_ptr<PingSynthesis> make_double_array_synthesis(const SynthesisTables& tables) {
  return std::make_unique<DoubleArraySynthesis>(tables);
}

}  // namespace ensonify
