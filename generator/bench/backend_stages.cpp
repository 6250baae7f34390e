// The one place that looks inside the CPU backend.
#include <algorithm>
#include <cmath>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "bench/stages.h"
#include "bench/timing.h"
#include "core/units.h"
#include "synthesis/cpu/beam_mixer.h"
#include "synthesis/cpu/fft.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/draw.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

class BackendStages {
 public:
  explicit BackendStages(const SynthesisSetup& setup)
      : setup_(setup),
        stride_((setup.record.transform + 3) / 4 * 4),
        source_pa_m_(source_pressure_pa_m(setup.sonar)),
        pulse_(pulse_spectrum(setup.sonar, setup.record.transform)),
        kernel_(make_gridding_kernel(2 * setup.record.transform, setup.record.transform / 2)),
        forward_(kernel_.grid, FftDirection::forward),
        backward_(setup.record.transform, FftDirection::backward),
        mixer_(make_mixing(setup.sonar)),
        rows_(std::size_t(setup.sonar.beam_count) * stride_) {}

  void ray_sum(const ScattererList& list, const std::vector<std::complex<float>>& amplitude) {
    const int half = setup_.record.transform / 2;
    for (int beam = 0; beam < setup_.sonar.beam_count; ++beam) {
      AlignedBuffer<Complex> grid(kernel_.grid);
      for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
        const Scatterer& s = list.items[i];
        const double turns = carrier_turns(setup_.sonar.frequency_hz, s.delay_s);
        const Complex echo = Complex(amplitude[i]) * static_cast<double>(s.gain) *
                             std::polar(source_pa_m_, -2.0 * kPi * turns);
        const double x = s.delay_s * setup_.sonar.bandwidth_hz / setup_.record.transform;
        spread(kernel_, x, echo, grid.data());
      }
      forward_.run(grid.data());
      Complex* row = rows_.data() + std::size_t(beam) * stride_;
      for (int k = -half; k < half; ++k) {
        const Complex sum = grid[k < 0 ? k + kernel_.grid : k];
        row[k < 0 ? k + 2 * half : k] = pulse_[k + half] * kernel_.correction[std::abs(k)] * sum;
      }
    }
  }

  // In place: the rows grow from run to run, which costs nothing while they are numbers.
  void transform() {
    for (int beam = 0; beam < setup_.sonar.beam_count; ++beam) {
      backward_.run(rows_.data() + std::size_t(beam) * stride_);
    }
  }

  void mix(const Workers& workers) {
    mixer_.mix_amplitude(rows_.data(), setup_.record.samples, stride_, workers);
  }

 private:
  SynthesisSetup setup_;
  int stride_;
  double source_pa_m_;
  std::vector<Complex> pulse_;
  GriddingKernel kernel_;
  ComplexFft forward_, backward_;
  BeamMixer mixer_;
  AlignedBuffer<Complex> rows_;
};

}  // namespace

std::vector<std::complex<float>> drawn_amplitudes(const ScattererList& list,
                                                  const RandomKeys& keys) {
  std::vector<std::complex<float>> amplitude(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) amplitude[i] = draw_amplitude(list.items[i], keys);
  return amplitude;
}

void time_backend_stages(const Bench& bench, const ScattererList& list, CaseReport& report) {
  const Workers one(1);
  const double seconds = bench.options.seconds;
  const auto add = [&](const char* name, double ms) { report.stages.push_back({name, ms}); };

  std::vector<std::complex<float>> amplitude;
  add("speckle", median_ms(seconds, [&] { amplitude = drawn_amplitudes(list, bench.keys); }));
  BackendStages stages(bench.setup);
  add("ray_sum", median_ms(seconds, [&] { stages.ray_sum(list, amplitude); }));
  add("fft", median_ms(seconds, [&] { stages.transform(); }));
  stages.ray_sum(list, amplitude);
  add("mixing", median_ms(seconds, [&] { stages.mix(one); }));
}

}  // namespace ensonify
