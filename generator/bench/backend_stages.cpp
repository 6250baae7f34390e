// The one place that looks inside the CPU backend.
#include <algorithm>

#include "acoustics/pulse.h"
#include "bench/stages.h"
#include "bench/timing.h"
#include "synthesis/cpu/echoes.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/draw.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

// The fast path's stages for the series alone. `plan` is none where the setup asks for an error
// that only the path in double precision holds.
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

}  // namespace ensonify
