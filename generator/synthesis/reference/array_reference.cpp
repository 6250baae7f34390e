// Computes every scatterer at every element and frequency, with the delay of this path. Every beam
// adds the elements' records, each delayed by a phase at every frequency and focused at every
// sample.
#include "synthesis/reference/array_reference.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/units.h"
#include "synthesis/adc.h"
#include "synthesis/beamforming.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

// Discrete Fourier transforms of 2-3-5-smooth lengths, split into sums over prime factors only.
// The reference does not use FFTW, so that it shares no transform with the backends that it tests.
class PlainDft {
 public:
  using Complex = std::complex<double>;

  explicit PlainDft(int length) : length_(length) {
    for (int k = 0; k < length; ++k) turn_.push_back(std::polar(1.0, 2 * kPi * k / length));
  }

  // X_k = sum_n x_n e^(i 2 pi k n / length).
  std::vector<Complex> operator()(const std::vector<Complex>& x) const {
    std::vector<Complex> out(x.size());
    sum(x.data(), 1, out.data(), length_);
    return out;
  }

 private:
  // Transforms `count` values of x, each `stride` after the one before.
  void sum(const Complex* x, int stride, Complex* out, int count) const {
    if (count == 1) {
      *out = *x;
      return;
    }
    int factor = 2;
    while (count % factor != 0) ++factor;
    const int part = count / factor, step = length_ / count;
    for (int r = 0; r < factor; ++r) sum(x + r * stride, stride * factor, out + r * part, part);
    std::vector<Complex> one(factor);
    for (int k = 0; k < part; ++k) {
      for (int r = 0; r < factor; ++r) one[r] = out[r * part + k];
      for (int s = 0; s < factor; ++s) {
        const long index = k + s * part;
        Complex value = one[0];
        for (int r = 1; r < factor; ++r) value += one[r] * turn_[r * index % count * step];
        out[index] = value;
      }
    }
  }

  int length_;
  std::vector<Complex> turn_;
};

using Complex = std::complex<double>;
using Records = std::vector<std::vector<Complex>>;  // [elements][bins], spectra

// A sound of amplitude 1 that arrives at the array.
struct Sound {
  Vec3 apparent_m;
  double cosine = 0;           // between its direction and the line
  double delay_s = 0;          // at the origin
  double carrier_delay_s = 0;  // the part of the delay that changes the carrier's phase
  double doppler = 0;
};

Sound sound_of(const Scatterer& s) {
  const Direction& from = s.arrival;
  return {apparent_point_m(s), unit_vector(from.azimuth_rad, from.elevation_rad).y, s.delay_s,
          s.delay_s, static_cast<double>(s.doppler)};
}

class ArrayReference final : public Backend {
 public:
  explicit ArrayReference(const SynthesisSetup& setup)
      : setup_(setup),
        array_(*setup.sonar.array),
        geometry_(make_array_geometry(setup.sonar)),
        spectrum_(pulse_spectrum(setup.sonar, setup.record.transform)),
        shifted_(make_doppler_pulse(setup.sonar, setup.record.transform)),
        dft_(setup.record.transform),
        source_pa_m_(source_pressure_pa_m(setup.sonar)) {}

  SynthesisMemory memory(bool) const override {
    const std::uint64_t row = bins() * sizeof(Complex);
    const std::uint64_t pixels = std::uint64_t(beams()) * samples();
    return {3 * row, 3 * elements() * row + pixels * (2 * sizeof(Complex) + sizeof(double)),
            sizeof(Complex), 4 * row};
  }

  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    for (std::size_t i = 0; i < tasks.size(); ++i) series[i] = one_ping(tasks[i], workers);
  }

 private:
  int elements() const { return array_.elements; }
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }
  int bins() const { return setup_.record.transform; }
  double carrier_hz() const { return setup_.sonar.frequency_hz; }
  double speed_m_s() const { return setup_.water.sound_speed_m_s; }
  double bin_hz(int m) const { return (m - bins() / 2) * setup_.sonar.bandwidth_hz / bins(); }

  PingSeries one_ping(const PingTask& task, const Workers& workers) const;
  Sound sound_of_cell(int beam, int sample) const;
  void add_sound(const Sound& sound, Complex amplitude, int element,
                 std::vector<Complex>& spectrum) const;
  Records drawn_records(const PingTask& task, const Workers& workers) const;
  void add_noise(const PingTask& task, int element, std::vector<Complex>& spectrum) const;
  std::vector<Complex> in_time(const std::vector<Complex>& spectrum) const;
  std::vector<Complex> beam_series(const Records& records, int beam) const;
  SampleArray<float> clean_power(const PingTask& task, const Workers& workers) const;
  void add_power(const Sound& sound, double energy, std::vector<double>& power,
                 const Workers& workers) const;

  SynthesisSetup setup_;
  ArrayReceiver array_;
  ArrayGeometry geometry_;
  std::vector<Complex> spectrum_;
  DopplerPulse shifted_;
  PlainDft dft_;
  double source_pa_m_;
};

// The sound of volumes from one sample of a beam cell: at the azimuth of the beam and the range of
// the sample. Its amplitude is drawn, so that only the differences between elements matter
// for its carrier phase.
Sound ArrayReference::sound_of_cell(int beam, int sample) const {
  const double azimuth = beam_azimuth_rad(setup_.sonar, beam);
  const double range_m = focus_range_m(setup_.sonar, setup_.water, sample);
  return {range_m * unit_vector(azimuth, 0), std::sin(azimuth),
          sample * setup_.record.sample_interval_s, 0};
}

// Adds to every bin m
//   response E S0 S(f_m) amplitude
//     e^(-i 2 pi (f_c (carrier delay + delta) + (f_m - f_c) (delay + delta))).
void ArrayReference::add_sound(const Sound& sound, Complex amplitude, int element,
                               std::vector<Complex>& spectrum) const {
  const double later = element_delay_s(sound.apparent_m, geometry_.y_m[element], speed_m_s());
  const double heard =
      element_pattern(sound.cosine, array_.element_width_m, speed_m_s() / carrier_hz());
  const Complex factor = geometry_.response[element] * heard * source_pa_m_ * amplitude;
  const double turns = carrier_turns(carrier_hz(), sound.carrier_delay_s + later);
  for (int m = 0; m < bins(); ++m) {
    const double more = carrier_turns(bin_hz(m), sound.delay_s + later);
    const Complex pulse =
        sound.doppler == 0 ? spectrum_[m] : doppler_bin(shifted_, sound.doppler, m);
    spectrum[m] += factor * pulse * std::polar(1.0, -2 * kPi * (turns + more));
  }
}

// Draws noise for the whole period, so that a delayed record has the same noise power at its ends.
void ArrayReference::add_noise(const PingTask& task, int element,
                               std::vector<Complex>& spectrum) const {
  if (task.noise_power_pa2 == 0 || geometry_.response[element] == Complex(0)) return;
  const double power = element_noise_power_pa2(geometry_, task.noise_power_pa2);
  std::vector<Complex> record;
  for (int n = 0; n < bins(); ++n) {
    // dft_ is an inverse transform. With conjugates it acts as a forward one, and the alternating
    // sign moves the start of the band to -M/2.
    const Complex p = std::conj(draw_noise(task.keys, element, n, power));
    record.push_back(n % 2 == 0 ? p : -p);
  }
  const std::vector<Complex> sum = dft_(record);
  for (int m = 0; m < bins(); ++m) spectrum[m] += std::conj(sum[m]) / double(bins());
}

Records ArrayReference::drawn_records(const PingTask& task, const Workers& workers) const {
  std::vector<Complex> amplitude;
  for (const Scatterer& s : task.scatterers->items) {
    amplitude.push_back(Complex(draw_amplitude(s, task.keys)) * double(s.gain));
  }
  Records records(elements(), std::vector<Complex>(bins()));
  workers.for_each(elements(), [&](std::size_t at) {
    const int element = static_cast<int>(at);
    for (std::size_t i = 0; i < amplitude.size(); ++i) {
      add_sound(sound_of(task.scatterers->items[i]), amplitude[i], element, records[at]);
    }
    for (int cell = 0; !task.volumes.empty() && cell < beams() * samples(); ++cell) {
      const int beam = cell / samples(), sample = cell % samples();
      const double energy = total_energy(task.volumes, cell);
      if (energy == 0) continue;
      add_sound(sound_of_cell(beam, sample), draw_volume(task.keys, beam, sample, energy), element,
                records[at]);
    }
    add_noise(task, element, records[at]);
  });
  return records;
}

// The samples of a spectrum. The factor e^(-i pi n) is there because the band starts at -M/2.
std::vector<Complex> ArrayReference::in_time(const std::vector<Complex>& spectrum) const {
  std::vector<Complex> record = dft_(spectrum);
  for (int n = 1; n < bins(); n += 2) record[n] = -record[n];
  record.resize(samples());
  return record;
}

std::vector<Complex> ArrayReference::beam_series(const Records& records, int beam) const {
  const double azimuth = beam_azimuth_rad(setup_.sonar, beam);
  std::vector<Complex> series(samples());
  for (int element = 0; element < elements(); ++element) {
    const double y = geometry_.y_m[element];
    const double later = steering_delay_s(y, azimuth, speed_m_s());
    std::vector<Complex> spectrum = records[element];
    for (int m = 0; m < bins() && array_.steering == Steering::true_delay; ++m) {
      spectrum[m] *= std::polar(1.0, 2 * kPi * bin_hz(m) * later);
    }
    const std::vector<Complex> record = in_time(spectrum);
    for (int n = 0; n < samples(); ++n) {
      double turns = carrier_hz() * later;
      if (array_.focus == Focus::dynamic) {
        const double range_m = focus_range_m(setup_.sonar, setup_.water, n);
        turns += carrier_hz() * focus_delay_s(y, azimuth, range_m, speed_m_s());
      }
      series[n] += geometry_.weight[element] * std::polar(1.0, 2 * kPi * turns) * record[n];
    }
  }
  return series;
}

PingSeries ArrayReference::one_ping(const PingTask& task, const Workers& workers) const {
  for (const VolumeEcho& volume : task.volumes) {
    ENSONIFY_ASSERT(volume.energy.size() == std::size_t(beams()) * samples());
  }
  const Records records = drawn_records(task, workers);
  PingSeries series;
  series.pressure_pa.resize(std::size_t(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t beam) {
    const std::vector<Complex> sum = beam_series(records, static_cast<int>(beam));
    for (int n = 0; n < samples(); ++n) {
      series.pressure_pa[beam * samples() + n] = std::complex<float>(sum[n]);
    }
  });
  for (int element = 0; task.wants_channels && element < elements(); ++element) {
    for (const Complex p : in_time(records[element])) {
      series.channels_pa.emplace_back(std::complex<float>(p));
    }
  }
  if (task.converts && setup_.sonar.adc) quantise(*setup_.sonar.adc, series.pressure_pa);
  if (task.wants_clean) series.clean_power_pa2 = clean_power(task, workers);
  return series;
}

// Adds energy |h_j(t)|^2 for every beam j.
void ArrayReference::add_power(const Sound& sound, double energy, std::vector<double>& power,
                               const Workers& workers) const {
  if (energy == 0) return;
  Records records(elements(), std::vector<Complex>(bins()));
  workers.for_each(elements(), [&](std::size_t element) {
    add_sound(sound, 1.0, static_cast<int>(element), records[element]);
  });
  workers.for_each(beams(), [&](std::size_t beam) {
    const std::vector<Complex> h = beam_series(records, static_cast<int>(beam));
    for (int n = 0; n < samples(); ++n) power[beam * samples() + n] += energy * std::norm(h[n]);
  });
}

SampleArray<float> ArrayReference::clean_power(const PingTask& task, const Workers& workers) const {
  const std::vector<Scatterer>& items = task.scatterers->items;
  Records means(elements(), std::vector<Complex>(bins()));
  workers.for_each(elements(), [&](std::size_t element) {
    for (const Scatterer& s : items) {
      add_sound(sound_of(s), Complex(s.mean) * double(s.gain), static_cast<int>(element),
                means[element]);
    }
  });
  std::vector<double> power(std::size_t(beams()) * samples());
  workers.for_each(beams(), [&](std::size_t beam) {
    const std::vector<Complex> mean = beam_series(means, static_cast<int>(beam));
    for (int n = 0; n < samples(); ++n) power[beam * samples() + n] = std::norm(mean[n]);
  });
  for (const Scatterer& s : items) {
    const double amplitude = double(s.standard_deviation) * s.gain;
    Sound sound = sound_of(s);
    sound.doppler = 0;
    add_power(sound, amplitude * amplitude, power, workers);
  }
  for (int cell = 0; !task.volumes.empty() && cell < beams() * samples(); ++cell) {
    add_power(sound_of_cell(cell / samples(), cell % samples()), total_energy(task.volumes, cell),
              power, workers);
  }
  return {power.begin(), power.end()};
}

}  // namespace

std::unique_ptr<Backend> make_array_reference_backend(const SynthesisSetup& setup) {
  ENSONIFY_ASSERT(setup.sonar.array.has_value());
  return std::make_unique<ArrayReference>(setup);
}

}  // namespace ensonify
