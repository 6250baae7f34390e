#include "synthesis/cpu/array_synthesis.h"

#include <algorithm>

#include "synthesis/cpu/array_beams.h"
#include "synthesis/cpu/array_nodes.h"
#include "synthesis/cpu/array_power.h"
#include "synthesis/cpu/array_records.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

struct ArrayScratch {
  ArrayEchoes echoes;
  AlignedBuffer<Complex> spectra;
  NodeRecords nodes;
  FineRecords fine;
  std::vector<std::complex<float>> mean;
};

class ArraySynthesis final : public PingSynthesis {
 public:
  ArraySynthesis(const SynthesisTables& tables, std::shared_ptr<const ArrayPlan> plan)
      : plan_(std::move(plan)),
        nodes_(make_array_nodes(*plan_)),
        kernels_(kernels_of(tables.setup.simd)),
        power_(make_array_power(tables)) {}

  SynthesisMemory memory(bool has_volumes) const override;
  void run(const PingTask& task, PingSeries& result, const Workers& workers) const override;

 private:
  std::size_t cells() const { return std::size_t(plan_->beams()) * plan_->samples(); }
  int near_samples() const { return nodes_ ? nodes_->near_samples : plan_->samples(); }
  void spectra(const PingTask& task, EchoAmplitude amplitude, ArrayScratch& scratch,
               const Workers& workers) const;
  void beams(ArrayScratch& scratch, std::complex<float>* series, const Workers& workers) const;
  void clean_power(const PingTask& task, ArrayScratch& scratch, PingSeries& result,
                   const Workers& workers) const;

  std::shared_ptr<const ArrayPlan> plan_;
  std::shared_ptr<const ArrayNodes> nodes_;  // none: all samples as those near by
  const Kernels& kernels_;
  std::unique_ptr<const ArrayPower> power_;
  mutable Pool<ArrayScratch> ping_pool_;
  mutable Pool<PointChunk> chunk_pool_;
  mutable Pool<RecordScratch> record_pool_;
  mutable Pool<SteerScratch> steer_pool_;
};

SynthesisMemory ArraySynthesis::memory(bool) const {
  SynthesisMemory memory = power_->memory();
  memory.shared_bytes += plan_->taps.tap.size() * (sizeof(float) + sizeof(std::int32_t) / 8.0);
  memory.ping_bytes += std::uint64_t(plan_->elements()) * plan_->bins() * sizeof(Complex) +
                       fine_bytes(*plan_, near_samples()) + cells() * sizeof(std::complex<float>);
  if (nodes_) {
    memory.shared_bytes += node_table_bytes(*nodes_);
    memory.ping_bytes += node_ping_bytes(*plan_, *nodes_);
    memory.thread_bytes += node_thread_bytes(*plan_, *nodes_);
  }
  memory.echo_bytes += 4 * sizeof(double) + 2 * sizeof(float);
  memory.thread_bytes += record_scratch_bytes(*plan_) + sizeof(PointChunk);
  return memory;
}

void ArraySynthesis::spectra(const PingTask& task, EchoAmplitude amplitude, ArrayScratch& scratch,
                             const Workers& workers) const {
  gather_echoes(*plan_, kernels_, task, amplitude, chunk_pool_, workers, scratch.echoes);
  element_spectra(*plan_, kernels_, task, scratch.echoes, amplitude, record_pool_, workers,
                  scratch.spectra);
}

void ArraySynthesis::beams(ArrayScratch& scratch, std::complex<float>* series,
                           const Workers& workers) const {
  if (const int near = near_samples(); near > 0) {
    make_fine_records(*plan_, scratch.spectra, near, record_pool_, workers, scratch.fine);
    direct_beams(*plan_, kernels_, scratch.fine, near, workers, series);
  }
  if (!nodes_) return;
  node_beams(*plan_, *nodes_, kernels_, scratch.spectra, steer_pool_, workers, scratch.nodes,
             series);
}

void ArraySynthesis::clean_power(const PingTask& task, ArrayScratch& scratch, PingSeries& result,
                                 const Workers& workers) const {
  power_->diffuse(task, result.clean_power_pa2, workers);
  if (!has_means(task)) return;
  spectra(task, EchoAmplitude::mean, scratch, workers);
  scratch.mean.resize(cells());
  beams(scratch, scratch.mean.data(), workers);
  workers.for_each(plan_->beams(), [&](std::size_t beam) {
    const std::size_t first = beam * plan_->samples();
    for (std::size_t i = first; i < first + plan_->samples(); ++i) {
      result.clean_power_pa2[i] += std::norm(scratch.mean[i]);
    }
  });
}

void ArraySynthesis::run(const PingTask& task, PingSeries& result, const Workers& workers) const {
  auto scratch = ping_pool_.take();
  result.pressure_pa.resize(cells());
  spectra(task, EchoAmplitude::drawn, *scratch, workers);
  beams(*scratch, result.pressure_pa.data(), workers);
  const std::size_t channels = std::size_t(plan_->elements()) * plan_->samples();
  result.channels_pa.resize(task.wants_channels ? channels : 0);
  if (task.wants_channels) {
    element_series(*plan_, scratch->spectra, record_pool_, workers, result.channels_pa.data());
  }
  if (task.wants_clean) {
    clean_power(task, *scratch, result, workers);
  } else {
    result.clean_power_pa2.clear();
  }
}

}  // namespace

std::unique_ptr<PingSynthesis> make_array_synthesis(const SynthesisTables& tables) {
  std::shared_ptr<const ArrayPlan> plan = make_array_plan(tables);
  if (!plan) return nullptr;
  return std::make_unique<ArraySynthesis>(tables, std::move(plan));
}

}  // namespace ensonify
