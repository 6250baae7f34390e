// The stages of the synthesis, of the CPU backend and of the plain methods.
#include <algorithm>
#include <cmath>

#include "acoustics/pulse.h"
#include "bench/machine.h"
#include "bench/stages.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

// The fast path's stages for the series alone. `plan` is none if only the double-precision path
// meets the setup's error.
class BackendStages {
 public:
  explicit BackendStages(const SynthesisSetup& setup)
      : setup_(setup),
        kernels_(kernels_of(setup.simd)),
        plan_(make_series_plan(setup, make_mixing(setup.sonar),
                               pulse_spectrum(setup.sonar, setup.record.transform),
                               setup.tolerance)),
        series_(std::size_t(setup.sonar.beam_count) * setup.record.samples) {}

  bool has_plan() const { return plan_ != nullptr; }

  void draw_and_place(const PingTask& task) {
    series_echoes(*plan_, kernels_, setup_.sonar, task, EchoAmplitude::drawn, echo_pool_, one_,
                  echoes_);
  }

  void sum_and_transform(const ScattererList& list) {
    transform_nodes(*plan_, kernels_, echoes_, list.beam_offset, node_pool_, one_, planes_);
  }

  void mix() {
    const int step = plan_->tile_samples(), samples = setup_.record.samples;
    auto scratch = node_pool_.take();
    auto* out = reinterpret_cast<float*>(series_.data());
    for (int first = 0; first < samples; first += step) {
      const float* mixed = mix_tile(*plan_, kernels_, planes_.data(), first / step, *scratch);
      const int width = plan_->nodes.width;
      alignas(64) float values[kTile];
      for (int beam = 0; beam < plan_->nodes.beams; ++beam) {
        kernels_.combine(plan_->out_weight.data() + std::size_t(beam) * width, width,
                         mixed + std::size_t(plan_->nodes.first[beam]) * kTile, values);
        kernels_.store_complex(values, nullptr, std::min(step, samples - first),
                               out + 2 * (std::size_t(beam) * samples + first));
      }
    }
  }

 private:
  SynthesisSetup setup_;
  const Kernels& kernels_;
  std::unique_ptr<const NodePlan> plan_;
  std::vector<std::complex<float>> series_;
  Workers one_{1};
  Pool<EchoScratch> echo_pool_;
  Pool<NodeScratch> node_pool_;
  EchoBuffer echoes_;
  AlignedBuffer<float> planes_{0};
};

// Sectors that stand for all in the check of the plain methods.
constexpr int kCheckedSectors = 32;

std::vector<int> every_nth_sector(int beams, int step) {
  std::vector<int> sectors;
  for (int sector = step / 2; sector < beams; sector += step) sectors.push_back(sector);
  return sectors;
}

std::size_t scatterers_in(const ScattererList& list, const std::vector<int>& sectors) {
  std::size_t count = 0;
  for (const int s : sectors) count += list.beam_offset[s + 1] - list.beam_offset[s];
  return count;
}

double spectra_error(const PlainMethod& plain, const std::vector<std::complex<double>>& exact,
                     const std::vector<int>& sectors, int bins) {
  double wrong = 0, whole = 0;
  for (const int sector : sectors) {
    for (int m = 0; m < bins; ++m) {
      const std::complex<double> e = exact[std::size_t(sector) * bins + m];
      wrong += std::norm(std::complex<double>(plain.spectrum(sector)[m]) - e);
      whole += std::norm(e);
    }
  }
  return std::sqrt(wrong / whole);
}

}  // namespace

std::vector<std::complex<float>> drawn_amplitudes(const ScattererList& list,
                                                  const RandomKeys& keys) {
  std::vector<std::complex<float>> amplitude(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) amplitude[i] = draw_amplitude(list.items[i], keys);
  return amplitude;
}

void time_backend_stages(const Bench& bench, const ScattererList& list, CaseReport& report) {
  const double seconds = bench.options.seconds;
  BackendStages stages(bench.setup);
  if (!stages.has_plan()) return;
  const PingTask task{&list, bench.keys, 0, {}};
  const auto add = [&](const char* name, double ms) { report.stages.push_back({name, ms}); };
  add("speckle", median_ms(seconds, [&] { stages.draw_and_place(task); }));
  add("ray_sum_and_fft", median_ms(seconds, [&] { stages.sum_and_transform(list); }));
  add("mixing", median_ms(seconds, [&] { stages.mix(); }));
}

PlainTimes time_plain_methods(const Bench& bench, const ScattererList& list,
                              const std::vector<std::complex<float>>& amplitude,
                              const Workers& workers, std::vector<Timing>* references) {
  const double seconds = bench.options.seconds;
  const int beams = bench.setup.sonar.beam_count, bins = bench.setup.record.transform;
  PlainMethod plain(bench.setup, best_kernels());
  const auto add = [&](Timing timing) {
    if (references != nullptr) references->push_back(std::move(timing));
  };
  const auto time_sum = [&](RaySum method, const char* name) {
    // One run over a few beam cells estimates how many fit into the time of three runs.
    std::vector<int> sectors = every_nth_sector(beams, std::max(1, beams / 16));
    const StopWatch watch;
    plain.ray_sum(method, list, amplitude, sectors, workers);
    const double all_ms =
        watch.ms() * list.size() / std::max<std::size_t>(1, scatterers_in(list, sectors));
    const double runs = 3 * all_ms / std::max(1.0, 1000 * seconds);
    const int step =
        std::clamp(static_cast<int>(std::lround(runs / 2)), 1, std::max(1, beams / 16));
    sectors = every_nth_sector(beams, step);
    const double part = static_cast<double>(scatterers_in(list, sectors)) / list.size();
    const double ms =
        median_ms(seconds, [&] { plain.ray_sum(method, list, amplitude, sectors, workers); });
    add({name, ms / part, part, 0, ""});
    return ms / part;
  };
  const double direct = time_sum(RaySum::direct, "ray_sum_direct");
  const double recurrence = time_sum(RaySum::recurrence, "ray_sum_recurrence");

  const double peak = bench.machine.fma_gflops * 1e6;  // flops in a ms
  const double mixing = median_ms(seconds, [&] { plain.mix(workers); });
  add({"mixing_full", mixing, 1, 4.0 * beams * beams * bins / mixing / peak, "fma"});
  std::vector<std::complex<float>> series;
  const double fft = median_ms(seconds, [&] { plain.transform(series, workers); });
  add({"fft_rows", fft, 1, 5.0 * beams * bins * std::log2(bins) / fft / peak, "fma"});
  return {direct + mixing + fft, recurrence + mixing + fft};
}

void check_plain_methods(const Bench& bench, const ScattererList& list,
                         const std::vector<std::complex<float>>& amplitude,
                         const std::vector<std::complex<double>>& exact, const Workers& workers,
                         CaseReport& report) {
  PlainMethod plain(bench.setup, best_kernels());
  const int beams = bench.setup.sonar.beam_count, bins = bench.setup.record.transform;
  const std::vector<int> sectors = every_nth_sector(beams, std::max(1, beams / kCheckedSectors));
  plain.ray_sum(RaySum::direct, list, amplitude, sectors, workers);
  report.direct_error = spectra_error(plain, exact, sectors, bins);
  plain.ray_sum(RaySum::recurrence, list, amplitude, sectors, workers);
  report.recurrence_error = spectra_error(plain, exact, sectors, bins);
}

}  // namespace ensonify
