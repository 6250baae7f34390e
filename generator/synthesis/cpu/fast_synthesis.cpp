// The fast path: runs the stages of node_sums.h for time series, expected power and mean, and those
// of draws.h for several pings of one scene.
#include <algorithm>
#include <cmath>

#include "synthesis/cpu/draws.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/cpu/shifted_echoes.h"

namespace ensonify {
namespace {

// The tolerance of the mean. In the expected power, its relative error is twice as large.
constexpr double kCleanTolerance = 3e-5;

// The memory of one ping in work, in addition to the scratch memory of workers.
struct SeriesScratch {
  EchoBuffer echoes;
  AlignedBuffer<float> planes;
  std::vector<ShiftedSet> sets;  // of echoes with Doppler
};

// Noise of one beam over one tile: all real parts, then all imaginary parts.
class TileNoise {
 public:
  TileNoise(const Kernels& kernels, const PingTask& task)
      : kernels_(kernels),
        keys_(task.keys),
        rms_pa_(static_cast<float>(std::sqrt(task.noise_power_pa2))) {}

  const float* draw(int beam, int first_sample) {
    if (rms_pa_ == 0) return nullptr;
    constexpr int kSamples = kTile / 2;
    for (int i = 0; i < kSamples; ++i) {
      sample_[i] = static_cast<std::uint32_t>(first_sample + i);
      beam_[i] = static_cast<std::uint32_t>(beam);
    }
    kernels_.draw_normals(keys_.noise, keys_.noise_ping, sample_, beam_, kSamples, tile_,
                          tile_ + kSamples);
    for (float& value : tile_) value *= rms_pa_;
    return tile_;
  }

 private:
  const Kernels& kernels_;
  const RandomKeys& keys_;
  float rms_pa_;
  alignas(64) std::uint32_t sample_[kTile / 2], beam_[kTile / 2];
  alignas(64) float tile_[kTile];
};

class FastSynthesis final : public PingSynthesis {
 public:
  FastSynthesis(const SynthesisTables& tables, std::shared_ptr<const NodePlan> series,
                std::shared_ptr<const NodePlan> mean, std::shared_ptr<const NodePlan> power)
      : sonar_(tables.setup.sonar),
        samples_(tables.setup.record.samples),
        tolerance_(tables.setup.tolerance),
        kernels_(kernels_of(tables.setup.simd)),
        series_(std::move(series)),
        mean_(std::move(mean)),
        power_(std::move(power)) {}

  SynthesisMemory memory(bool has_volumes) const override;

  std::optional<SynthesisMemory> shifted_memory(bool has_volumes,
                                                std::uint64_t nodes) const override;

  void run(const PingTask& task, PingSeries& result, const Workers& workers) const override {
    synthesize(task, nullptr, result, workers);
  }
  bool run_shifted(const PingTask& task, const NodeSpectra& spectra, PingSeries& result,
                   const Workers& workers) const override {
    return synthesize(task, &spectra, result, workers);
  }
  int draws_at_once() const override { return kDraws; }
  void run_draws(std::span<const PingTask> tasks, std::span<PingSeries> results,
                 const Workers& workers) const override;

 private:
  // The spectra are null without Doppler. False if they have no filters.
  bool synthesize(const PingTask& task, const NodeSpectra* spectra, PingSeries& result,
                  const Workers& workers) const;
  bool series(const PingTask& task, const NodeSpectra* spectra, SeriesScratch& scratch,
              PingSeries& result, const Workers& workers) const;
  // Needs series() of the same ping first, which determines the kinds of amplitudes.
  void clean_power(const PingTask& task, const NodeSpectra* spectra, SeriesScratch& scratch,
                   PingSeries& result, const Workers& workers) const;
  void add_mean(const PingTask& task, const NodeSpectra* spectra, SeriesScratch& scratch,
                PingSeries& result, const Workers& workers) const;
  // Transforms the echoes in the buffer. With spectra, their sets have been placed.
  void transform(const NodePlan& plan, const PingTask& task, const NodeSpectra* spectra,
                 SeriesScratch& scratch, const Workers& workers) const;

  template <class Write>
  void mix(const NodePlan& plan, const float* planes, const Workers& workers, Write&& write) const;
  // Mixes the planes of the series, and adds noise.
  void mix_series(const PingTask& task, const float* planes, const Workers& workers,
                  PingSeries& result) const;

  Sonar sonar_;
  int samples_;
  double tolerance_;
  const Kernels& kernels_;
  std::shared_ptr<const NodePlan> series_, mean_, power_;
  mutable NodeFilters filters_;
  mutable Pool<SeriesScratch> ping_pool_;
  mutable Pool<DrawScratch> draw_pool_;
  mutable Pool<NodeScratch> node_pool_;
  mutable Pool<EchoScratch> echo_pool_;
};

SynthesisMemory FastSynthesis::memory(bool has_volumes) const {
  SynthesisMemory memory;
  for (const NodePlan* plan : {series_.get(), mean_.get(), power_.get()}) {
    if (plan == mean_.get() && mean_ == series_) continue;
    memory.shared_bytes += plan_bytes(*plan);
    // Plans run one after another in the same buffers.
    memory.ping_bytes = std::max(memory.ping_bytes, planes_bytes(*plan));
    memory.thread_bytes = std::max(memory.thread_bytes, scratch_bytes(*plan, has_volumes));
  }
  if (has_volumes) {
    memory.ping_bytes += std::uint64_t(sonar_.beam_count) * samples_ * sizeof(std::complex<float>);
  }
  memory.echo_bytes = 3 * sizeof(float) + sizeof(std::int32_t);
  memory.thread_bytes += sizeof(EchoScratch);
  return memory;
}

std::optional<SynthesisMemory> FastSynthesis::shifted_memory(bool has_volumes,
                                                             std::uint64_t nodes) const {
  SynthesisMemory result = memory(has_volumes);
  const std::uint64_t bins = series_->transform;
  result.shared_bytes += 2 * nodes * bins * sizeof(std::complex<double>);
  result.echo_bytes += nodes * result.echo_bytes + sizeof(double) + sizeof(float);
  result.thread_bytes += scratch_bytes(*series_, has_volumes, nodes);
  return result;
}

// Calls write(beam, first sample, samples, values of the tile) for all beams and times. One work
// item calls it for all beams of one stretch of time.
template <class Write>
void FastSynthesis::mix(const NodePlan& plan, const float* planes, const Workers& workers,
                        Write&& write) const {
  const int step = plan.tile_samples();
  workers.for_each((samples_ + step - 1) / step, [&](std::size_t item) {
    auto node_scratch = node_pool_.take();
    const int tile = static_cast<int>(item), first = tile * step;
    const float* mixed = mix_tile(plan, kernels_, planes, tile, *node_scratch);
    for (int beam = 0; beam < plan.nodes.beams; ++beam) {
      write(beam, first, std::min(step, samples_ - first),
            beam_tile(plan, kernels_, mixed, beam, *node_scratch));
    }
  });
}

bool FastSynthesis::synthesize(const PingTask& task, const NodeSpectra* spectra, PingSeries& result,
                               const Workers& workers) const {
  auto scratch = ping_pool_.take();
  scratch->echoes.keeps_shift = spectra != nullptr;
  if (!series(task, spectra, *scratch, result, workers)) return false;
  if (task.wants_clean) {
    clean_power(task, spectra, *scratch, result, workers);
  } else {
    result.clean_power_pa2.clear();
  }
  return true;
}

void FastSynthesis::transform(const NodePlan& plan, const PingTask& task,
                              const NodeSpectra* spectra, SeriesScratch& scratch,
                              const Workers& workers) const {
  const std::span<const std::uint32_t> beam_offset = task.scatterers->beam_offset;
  if (spectra) weigh_sets(spectra->nodes(), beam_offset, scratch.echoes, workers, scratch.sets);
  transform_nodes(plan, kernels_,
                  spectra ? echo_sets(scratch.sets) : whole_set(plan, scratch.echoes, beam_offset),
                  scratch.echoes, node_pool_, workers, scratch.planes);
}

bool FastSynthesis::series(const PingTask& task, const NodeSpectra* spectra, SeriesScratch& scratch,
                           PingSeries& result, const Workers& workers) const {
  series_echoes(*series_, kernels_, sonar_, {&task, 1}, EchoAmplitude::drawn, echo_pool_, workers,
                scratch.echoes);
  if (spectra && !place_sets(*series_, kernels_, sonar_, tolerance_, *spectra, filters_,
                             task.scatterers->beam_offset, scratch.echoes, workers, scratch.sets)) {
    return false;
  }
  transform(*series_, task, spectra, scratch, workers);
  mix_series(task, scratch.planes.data(), workers, result);
  return true;
}

void FastSynthesis::mix_series(const PingTask& task, const float* planes, const Workers& workers,
                               PingSeries& result) const {
  result.pressure_pa.resize(std::size_t(sonar_.beam_count) * samples_);
  auto* out = reinterpret_cast<float*>(result.pressure_pa.data());
  mix(*series_, planes, workers, [&](int beam, int first, int count, const float* values) {
    TileNoise noise(kernels_, task);
    kernels_.store_complex(values, noise.draw(beam, first), count,
                           out + 2 * (std::size_t(beam) * samples_ + first));
  });
}

void FastSynthesis::run_draws(std::span<const PingTask> tasks, std::span<PingSeries> results,
                              const Workers& workers) const {
  auto scratch = draw_pool_.take();
  for (std::size_t first = 0; first < tasks.size(); first += kDraws) {
    const auto batch = tasks.subspan(first, std::min<std::size_t>(kDraws, tasks.size() - first));
    if (batch.size() == 1) {
      run(batch[0], results[first], workers);
      continue;
    }
    series_echoes(*series_, kernels_, sonar_, batch, EchoAmplitude::drawn, echo_pool_, workers,
                  scratch->echoes);
    transform_draws(*series_, kernels_, scratch->echoes, batch[0].scatterers->beam_offset,
                    node_pool_, workers, scratch->planes);
    for (std::size_t d = 0; d < batch.size(); ++d) {
      PingSeries& result = results[first + d];
      mix_series(batch[d], scratch->planes_of(*series_, static_cast<int>(d)), workers, result);
      result.clean_power_pa2.clear();
    }
  }
}

void FastSynthesis::clean_power(const PingTask& task, const NodeSpectra* spectra,
                                SeriesScratch& scratch, PingSeries& result,
                                const Workers& workers) const {
  const bool has_means = scratch.echoes.has_means;
  result.clean_power_pa2.resize(std::size_t(sonar_.beam_count) * samples_);
  if (scratch.echoes.has_diffuse || !task.volumes.empty()) {
    power_echoes(*power_, kernels_, sonar_, task, echo_pool_, workers, scratch.echoes);
    transform(*power_, task, nullptr, scratch, workers);
    mix(*power_, scratch.planes.data(), workers,
        [&](int beam, int first, int count, const float* values) {
          kernels_.store_power(
              values, count, result.clean_power_pa2.data() + std::size_t(beam) * samples_ + first);
        });
  } else {
    std::fill(result.clean_power_pa2.begin(), result.clean_power_pa2.end(), 0.0f);
  }
  if (has_means) add_mean(task, spectra, scratch, result, workers);
}

void FastSynthesis::add_mean(const PingTask& task, const NodeSpectra* spectra,
                             SeriesScratch& scratch, PingSeries& result,
                             const Workers& workers) const {
  series_echoes(*mean_, kernels_, sonar_, {&task, 1}, EchoAmplitude::mean, echo_pool_, workers,
                scratch.echoes);
  // The nodes of Doppler are those of the series, whose tolerance is that of the mean.
  transform(*mean_, task, spectra, scratch, workers);
  mix(*mean_, scratch.planes.data(), workers,
      [&](int beam, int first, int count, const float* values) {
        kernels_.add_square(values, count,
                            result.clean_power_pa2.data() + std::size_t(beam) * samples_ + first);
      });
}

}  // namespace

std::unique_ptr<PingSynthesis> make_fast_synthesis(const SynthesisTables& tables) {
  const SynthesisSetup& setup = tables.setup;
  std::shared_ptr<const NodePlan> series =
      make_series_plan(setup, tables.mixing, tables.spectrum, setup.tolerance);
  std::shared_ptr<const NodePlan> mean = series;
  if (setup.tolerance > kCleanTolerance) {
    mean = make_series_plan(setup, tables.mixing, tables.spectrum, kCleanTolerance);
  }
  std::shared_ptr<const NodePlan> power =
      make_power_plan(setup, tables.mixing, tables.autospectrum);
  if (!series || !mean || !power) return nullptr;
  return std::make_unique<FastSynthesis>(tables, std::move(series), std::move(mean),
                                         std::move(power));
}

}  // namespace ensonify
