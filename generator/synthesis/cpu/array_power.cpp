#include "synthesis/cpu/array_power.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "synthesis/cpu/array_patterns.h"
#include "synthesis/cpu/node_sums.h"

namespace ensonify {
namespace {

struct PowerScratch {
  EchoBuffer echoes;
  AlignedBuffer<float> planes;
  std::vector<std::uint32_t> offset, next;
};

// Nodes in u that hold the power of echoes, and the patterns of all beams at them.
class NodePower final : public ArrayPower {
 public:
  explicit NodePower(const SynthesisTables& tables)
      : setup_(tables.setup),
        kernels_(kernels_of(setup_.simd)),
        grid_(make_power_grid(setup_)),
        plan_(make_array_power_plan(tables, grid_)) {}

  SynthesisMemory memory() const override;
  void diffuse(const PingTask& task, std::vector<float>& power,
               const Workers& workers) const override;

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }

  template <class Body>
  void for_each_echo(const PingTask& task, Body&& body) const;
  void sort_echoes(const PingTask& task, PowerScratch& scratch) const;
  void add_up(const PatternBlock& block, const PowerScratch& scratch, std::vector<float>& power,
              const Workers& workers) const;

  SynthesisSetup setup_;
  const Kernels& kernels_;
  PowerGrid grid_;
  std::unique_ptr<const NodePlan> plan_;
  mutable std::vector<PatternBlock> patterns_;
  mutable std::once_flag patterns_made_;
  mutable Pool<PowerScratch> ping_pool_;
  mutable Pool<NodeScratch> node_pool_;
};

// body(u, delay_s, power) for all that is diffuse.
template <class Body>
void NodePower::for_each_echo(const PingTask& task, Body&& body) const {
  const Sonar& sonar = setup_.sonar;
  const double source_pa_m = source_pressure_pa_m(sonar);
  for (const Scatterer& s : task.scatterers->items) {
    if (s.standard_deviation == 0) continue;
    const double a = source_pa_m * s.standard_deviation * s.gain;
    body(unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad).y, s.delay_s, a * a);
  }
  for (int j = 0; !task.volumes.empty() && j < beams(); ++j) {
    const double u = std::sin(beam_azimuth_rad(sonar, j));
    for (int n = 0; n < samples(); ++n) {
      const double energy = total_energy(task.volumes, std::size_t(j) * samples() + n);
      if (energy > 0) body(u, n / sonar.bandwidth_hz, source_pa_m * source_pa_m * energy);
    }
  }
}

// By cells of u, and in each as they come: the order of every sum.
void NodePower::sort_echoes(const PingTask& task, PowerScratch& scratch) const {
  scratch.offset.assign(grid_.cells + 1, 0);
  for_each_echo(task, [&](double u, double, double) { ++scratch.offset[grid_.cell_of(u) + 1]; });
  for (int c = 0; c < grid_.cells; ++c) scratch.offset[c + 1] += scratch.offset[c];
  scratch.next.assign(scratch.offset.begin(), scratch.offset.end() - 1);
  EchoBuffer& echoes = scratch.echoes;
  const std::size_t count = scratch.offset.back();
  echoes.value.need(2 * count);
  echoes.offset.need(count);
  echoes.first.need(count);
  echoes.has_echoes = count > 0;
  const double rate = setup_.sonar.bandwidth_hz / plan_->transform;
  for_each_echo(task, [&](double u, double delay_s, double power) {
    const std::uint32_t at = scratch.next[grid_.cell_of(u)]++;
    const auto value = static_cast<float>(power);
    echoes.value[2 * at] = echoes.value[2 * at + 1] = value;
    kernels_.place(rate, plan_->spread.points, plan_->spread.width, &delay_s, 1,
                   echoes.first.data() + at, echoes.offset.data() + at);
  });
}

void NodePower::add_up(const PatternBlock& block, const PowerScratch& scratch,
                       std::vector<float>& power, const Workers& workers) const {
  const int tiles = (block.end - block.begin + kTile - 1) / kTile;
  const int rows = static_cast<int>(block.packed.size() / plan_->nodes.nodes);
  workers.for_each(tiles, [&](std::size_t tile) {
    auto node_scratch = node_pool_.take();
    const int nodes = plan_->nodes.nodes;
    const int first = block.begin + static_cast<int>(tile) * kTile;
    const int count = std::min(kTile, block.end - first);
    node_scratch->tile.need(std::size_t(nodes + rows) * kTile);
    float* x = node_scratch->tile.data();
    float* y = x + std::size_t(nodes) * kTile;
    for (int q = 0; q < nodes; ++q) {
      const float* from = scratch.planes.data() + q * plan_->plane_stride() + first;
      std::copy_n(from, count, x + std::size_t(q) * kTile);
      std::fill_n(x + std::size_t(q) * kTile + count, kTile - count, 0.0f);
    }
    kernels_.product(block.packed.data(), rows, nodes, x, y);
    for (int j = 0; j < beams(); ++j) {
      kernels_.store_power(y + std::size_t(j) * kTile, count,
                           power.data() + std::size_t(j) * samples() + first);
    }
  });
}

SynthesisMemory NodePower::memory() const {
  SynthesisMemory memory;
  memory.shared_bytes = plan_bytes(*plan_) + pattern_bytes(setup_, grid_);
  memory.ping_bytes = planes_bytes(*plan_) + 2 * std::uint64_t(grid_.cells) * sizeof(std::uint32_t);
  memory.echo_bytes = 3 * sizeof(float) + sizeof(std::int32_t);
  memory.thread_bytes =
      scratch_bytes(*plan_, false) + std::uint64_t(beams() + kRowBlock) * kTile * sizeof(float);
  return memory;
}

void NodePower::diffuse(const PingTask& task, std::vector<float>& power,
                        const Workers& workers) const {
  power.assign(std::size_t(beams()) * samples(), 0.0f);
  auto scratch = ping_pool_.take();
  sort_echoes(task, *scratch);
  if (!scratch->echoes.has_echoes) return;
  std::call_once(patterns_made_, [&] { patterns_ = make_patterns(setup_, kernels_, grid_); });
  transform_nodes(*plan_, kernels_, scratch->echoes, scratch->offset, node_pool_, workers,
                  scratch->planes);
  for (const PatternBlock& block : patterns_) add_up(block, *scratch, power, workers);
}

}  // namespace

std::unique_ptr<const ArrayPower> make_array_power(const SynthesisTables& tables) {
  return std::make_unique<NodePower>(tables);
}

bool has_means(const PingTask& task) {
  const auto& items = task.scatterers->items;
  return std::any_of(items.begin(), items.end(), [](const Scatterer& s) { return s.mean != 0.0f; });
}

}  // namespace ensonify
