// The fast path for an array: the sums of its elements to beams, and all stages of a ping.
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "synthesis/cpu/array_nodes.h"
#include "synthesis/cpu/array_power.h"
#include "synthesis/cpu/array_records.h"
#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kSlabBeams = 32;

// A block of samples that one work item sums, and the number of elements that it expands together.
struct Block {
  int first, count;  // samples
  int padded;        // a multiple of 16
  int group;
};

// Floats of one plane. The margin is there because vectors of the last block may reach past its
// samples.
std::int64_t fine_stride(const ArrayPlan& plan, int samples) {
  return (samples + 2 * plan.taps.pad + 15) / 16 * 16 + 64;
}

// A lower bound of the distance from the focus to the nearest element.
double clearance_m(const ArrayPlan& plan, int sample) {
  const Sonar& sonar = plan.setup.sonar;
  const double range_m = focus_range_m(sonar, plan.setup.water, sample);
  const double end_m = std::abs(plan.geometry.y_m.front());
  const double edge = std::min(furthest_beam_rad(sonar), kPi / 2);
  return std::max(range_m - end_m, range_m * std::cos(edge));
}

// Divides samples [0, end) into blocks, each with the largest groups that its focus allows.
std::vector<Block> blocks_of(const ArrayPlan& plan, int end) {
  std::vector<Block> blocks;
  const bool focused = plan.setup.sonar.array->focus == Focus::dynamic;
  const auto group_at = [&](int n) {
    int group = kGroupElements;
    const double clear_m = clearance_m(plan, n);
    while (focused && group > 1 && clear_m < expansion_clearance_m(plan.setup, group)) group /= 2;
    return group;
  };
  for (int n = 0; n < end;) {
    const int group = group_at(n);
    const int count = std::min(group == kGroupElements ? kBeamBlock : 16, end - n);
    blocks.push_back({n, count, (count + 15) / 16 * 16, group});
    n += count;
  }
  return blocks;
}

// The points of focus at the samples of a block.
struct FocusPoints {
  alignas(64) double range_m[kPointChunk], along_m[kPointChunk], turns[kPointChunk],
      position[kPointChunk];
};

void fill_focus(const ArrayPlan& plan, const Block& block, double u, FocusPoints& points) {
  for (int t = 0; t < block.padded; ++t) {
    const int n = std::min(block.first + t, plan.samples());
    points.range_m[t] = focus_range_m(plan.setup.sonar, plan.setup.water, n);
    points.along_m[t] = points.range_m[t] * u;
    points.turns[t] = points.position[t] = 0;
  }
}

void fill_element(const ArrayPlan& plan, const FineRecords& fine, const Block& block, int beam,
                  int element, bool focused, BeamElement& e) {
  const std::size_t at = std::size_t(beam) * plan.elements() + element;
  const float* record = fine.planes.data() + std::int64_t{element} * 4 * fine.stride;
  const int half = 2 * (block.first + plan.taps.pad) + plan.taps.begin[at];
  e.even = record + (half & 1) * fine.stride + (half >> 1);
  e.odd = record + (~half & 1) * fine.stride + ((half + 1) >> 1);
  e.to_im = 2 * fine.stride;
  e.tap = plan.taps.tap.data() + at * kBeamTaps;
  const double weight = plan.geometry.weight[element];
  Complex turned = weight;
  if (!focused) {
    const double turns =
        plan.setup.sonar.frequency_hz * steering_delay_s(plan.geometry.y_m[element],
                                                         beam_azimuth_rad(plan.setup.sonar, beam),
                                                         plan.setup.water.sound_speed_m_s);
    turned = std::polar(weight, 2 * kPi * (turns - std::rint(turns)));
  }
  e.weight_re = static_cast<float>(turned.real());
  e.weight_im = static_cast<float>(turned.imag());
}

void one_beam(const ArrayPlan& plan, const Kernels& kernels, const FineRecords& fine,
              const Block& block, int beam, std::complex<float>* out) {
  const bool focused = plan.setup.sonar.array->focus == Focus::dynamic;
  const double turns_per_m = plan.setup.sonar.frequency_hz / plan.setup.water.sound_speed_m_s;
  alignas(64) float re[kBeamBlock] = {}, im[kBeamBlock] = {};
  FocusPoints focus;
  PathArrays paths;
  fill_focus(plan, block, std::sin(beam_azimuth_rad(plan.setup.sonar, beam)), focus);
  const PointArrays points = {focus.range_m, focus.along_m, focus.turns, focus.position};
  BeamElement elements[kGroupElements];
  for (int first = 0; first < plan.elements(); first += block.group) {
    const int count = std::min(block.group, plan.elements() - first);
    for (int l = 0; l < count; ++l) {
      fill_element(plan, fine, block, beam, first + l, focused, elements[l]);
    }
    if (focused) {
      const GroupLine line = plan.line(first, count, turns_per_m);
      kernels.array_paths(&line, &points, block.padded, &paths);
    }
    kernels.array_beam(elements, count, -(count - 1) / 2.0, focused ? &paths : nullptr,
                       block.padded, re, im);
  }
  for (int t = 0; t < block.count; ++t) out[t] = {re[t], im[t]};
}

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
  std::shared_ptr<const ArrayNodes> nodes_;  // null: all samples are summed directly
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

void make_fine_records(const ArrayPlan& plan, const AlignedBuffer<Complex>& spectra, int samples,
                       Pool<RecordScratch>& pool, const Workers& workers, FineRecords& fine) {
  fine.stride = fine_stride(plan, samples);
  const int bins = plan.bins(), half = bins / 2, pad = plan.taps.pad;
  fine.planes.need(4 * fine.stride * plan.elements());
  workers.for_each(plan.elements(), [&](std::size_t element) {
    auto scratch = pool.take();
    scratch->record.need(2 * bins);
    Complex* record = scratch->record.data();
    const Complex* spectrum = spectra.data() + element * bins;
    for (int k = 0; k < half; ++k) record[k] = spectrum[k] * plan.taps.correction[k];
    std::fill_n(record + half, bins, Complex(0));
    for (int k = half; k < bins; ++k) {
      record[bins + k] = spectrum[k] * plan.taps.correction[bins - k];
    }
    plan.fine_backward.run(record);
    float* re = fine.planes.data() + std::int64_t(element) * 4 * fine.stride;
    float* im = re + 2 * fine.stride;
    int n = (bins - pad % bins) % bins;
    for (std::int64_t i = 0; i < fine.stride; ++i, n = n + 1 < bins ? n + 1 : 0) {
      for (int phase = 0; phase < 2; ++phase) {
        re[phase * fine.stride + i] = static_cast<float>(record[2 * n + phase].real());
        im[phase * fine.stride + i] = static_cast<float>(record[2 * n + phase].imag());
      }
    }
  });
}

void direct_beams(const ArrayPlan& plan, const Kernels& kernels, const FineRecords& fine,
                  int samples, const Workers& workers, std::complex<float>* series) {
  const std::vector<Block> blocks = blocks_of(plan, samples);
  const int slabs = (plan.beams() + kSlabBeams - 1) / kSlabBeams;
  workers.for_each(blocks.size() * slabs, [&](std::size_t item) {
    const Block& block = blocks[item / slabs];
    const int first = static_cast<int>(item % slabs) * kSlabBeams;
    const int last = std::min(first + kSlabBeams, plan.beams());
    for (int beam = first; beam < last; ++beam) {
      one_beam(plan, kernels, fine, block, beam,
               series + std::size_t(beam) * plan.samples() + block.first);
    }
  });
}

std::uint64_t fine_bytes(const ArrayPlan& plan, int samples) {
  return 4 * std::uint64_t(fine_stride(plan, samples)) * plan.elements() * sizeof(float);
}

std::unique_ptr<PingSynthesis> make_array_synthesis(const SynthesisTables& tables) {
  std::shared_ptr<const ArrayPlan> plan = make_array_plan(tables);
  if (!plan) return nullptr;
  return std::make_unique<ArraySynthesis>(tables, std::move(plan));
}

}  // namespace ensonify
