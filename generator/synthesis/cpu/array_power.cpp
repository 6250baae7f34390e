#include "synthesis/cpu/array_power.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/units.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/node_sums.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// A power pattern needs at least two nodes per lobe, whose width is wavelength / aperture.
constexpr double kNodesPerLobe = 5;
// The length of a block without focus: wavefront curvature changes the phase at the array's end by
// kBendRad, or ranges have the ratio kRangeRatio if this block is longer. With dynamic focus, where
// curvature only affects side lobes, ranges have the ratio kFocusedRatio.
constexpr double kBendRad = 0.35, kRangeRatio = 1.08, kFocusedRatio = 1.5;

// Cubic interpolation from four nodes. The cell's middle lies between the second and the third.
void fill_cells(const PowerGrid& grid, BeamNodes& nodes) {
  nodes.beams = grid.cells;
  nodes.nodes = grid.nodes;
  nodes.width = kPatternTaps;
  for (int c = 0; c < grid.cells; ++c) {
    nodes.first.push_back(c / kCellsPerNode);
    const double t = 1 + (c % kCellsPerNode + 0.5) / kCellsPerNode;
    for (int a = 0; a < kPatternTaps; ++a) {
      double w = 1;
      for (int b = 0; b < kPatternTaps; ++b) {
        if (b != a) w *= (t - b) / (a - b);
      }
      nodes.weight.push_back(w);
    }
  }
}

// The spectrum of a pulse from the axis of a beam that is steered by phase.
std::vector<Complex> beam_spectrum(const SynthesisSetup& setup, const ArrayGeometry& geometry,
                                   const std::vector<Complex>& spectrum, double u) {
  const int bins = static_cast<int>(spectrum.size());
  std::vector<Complex> result(bins);
  Complex sum = 0;
  for (std::size_t n = 0; n < geometry.y_m.size(); ++n) {
    const Complex w = geometry.weight[n] * geometry.response[n];
    const double later = -geometry.y_m[n] * u / setup.water.sound_speed_m_s;
    const Complex step = std::polar(1.0, -2 * kPi * setup.sonar.bandwidth_hz / bins * later);
    Complex z = w * std::polar(1.0, kPi * setup.sonar.bandwidth_hz * later);
    for (int m = 0; m < bins; ++m, z *= step) result[m] += z * spectrum[m];
    sum += w;
  }
  for (Complex& s : result) s /= sum;
  return result;
}

// Both nodes of a row share the filter of the direction between them.
void fill_row_filters(const SynthesisTables& tables, const PowerGrid& grid, NodePlan& plan) {
  const ArrayGeometry geometry = make_array_geometry(tables.setup.sonar);
  const int bins = plan.transform;
  plan.row_filter.assign(std::size_t(plan.rows) * 2 * bins, Complex(0));
  const ComplexFft backward(2 * bins, FftDirection::backward);
  const ComplexFft forward(2 * bins, FftDirection::forward);
  AlignedBuffer<Complex> power(2 * bins);
  for (int row = 0; row < plan.rows; ++row) {
    const double u = (grid.node_u(2 * row) + grid.node_u(2 * row + 1)) / 2;
    const std::vector<Complex> heard = beam_spectrum(tables.setup, geometry, tables.spectrum, u);
    std::fill(power.begin(), power.end(), Complex(0));
    std::copy(heard.begin(), heard.end(), power.begin());
    backward.run(power.data());
    for (Complex& p : power) p = std::norm(p);
    forward.run(power.data());
    Complex* lower = plan.row_filter.data() + std::size_t(row) * 2 * bins;
    Complex* upper = lower + bins;
    for (int k = 0; k < bins; ++k) {
      lower[k] = power[k] / (2.0 * bins) * plan.grid.spread.correction[k];
      if (k == 0) continue;
      upper[k] = std::conj(power[bins - k]) / (2.0 * bins) * plan.grid.spread.correction[bins - k];
    }
  }
}

// Makes the packed matrix of the power patterns of all beams at one range.
class PatternMaker {
 public:
  PatternMaker(const SynthesisSetup& setup, const Kernels& kernels, const PowerGrid& grid)
      : setup_(setup),
        kernels_(kernels),
        grid_(grid),
        geometry_(make_array_geometry(setup.sonar)),
        elements_(static_cast<int>(geometry_.y_m.size())),
        rows_((setup.sonar.beam_count + kRowBlock - 1) / kRowBlock * kRowBlock) {}

  std::vector<float> patterns(double sample) const;

 private:
  // The delay of a wave from u at y, in turns of the carrier. The wave comes from `range_m` if it
  // is `bent`, and is plane otherwise.
  double turns(double y_m, double u, double range_m, bool bent) const {
    const double per_m = 1 / wavelength_m(setup_.sonar, setup_.water);
    if (!bent) return -y_m * u * per_m;
    const double square = y_m * y_m - 2 * y_m * range_m * u;
    return square / (std::sqrt(range_m * range_m + square) + range_m) * per_m;
  }
  // re and im: [rows_ / kRowBlock][2 elements][kRowBlock], for the real and the imaginary part of
  // the product.
  void beam_matrix(double range_m, std::vector<float>& re, std::vector<float>& im) const;

  const SynthesisSetup& setup_;
  const Kernels& kernels_;
  const PowerGrid& grid_;
  ArrayGeometry geometry_;
  int elements_, rows_;
};

void PatternMaker::beam_matrix(double range_m, std::vector<float>& re,
                               std::vector<float>& im) const {
  const bool focused = setup_.sonar.array->focus == Focus::dynamic;
  re.assign(std::size_t(rows_) * 2 * elements_, 0.0f);
  im = re;
  for (int j = 0; j < setup_.sonar.beam_count; ++j) {
    const double u = std::sin(beam_azimuth_rad(setup_.sonar, j));
    for (int n = 0; n < elements_; ++n) {
      const Complex w = geometry_.weight[n] * geometry_.response[n] *
                        std::polar(1.0, 2 * kPi * turns(geometry_.y_m[n], u, range_m, focused));
      const auto at = [&](int k) {
        return (std::size_t(j / kRowBlock) * 2 * elements_ + k) * kRowBlock + j % kRowBlock;
      };
      re[at(n)] = static_cast<float>(w.real());
      re[at(elements_ + n)] = static_cast<float>(-w.imag());
      im[at(n)] = static_cast<float>(w.imag());
      im[at(elements_ + n)] = static_cast<float>(w.real());
    }
  }
}

std::vector<float> PatternMaker::patterns(double sample) const {
  const double range_m = sample * setup_.water.sound_speed_m_s / (2 * setup_.sonar.bandwidth_hz);
  std::vector<float> re, im, packed(std::size_t(rows_) * grid_.nodes);
  beam_matrix(range_m, re, im);
  AlignedBuffer<float> x(std::size_t(2) * elements_ * kTile), y(std::size_t(2) * rows_ * kTile);
  for (int first = 0; first < grid_.nodes; first += kTile) {
    const int count = std::min(kTile, grid_.nodes - first);
    for (int n = 0; n < elements_; ++n) {
      for (int q = 0; q < count; ++q) {
        const double t = turns(geometry_.y_m[n], grid_.node_u(first + q), range_m, true);
        const Complex phase = std::polar(1.0, -2 * kPi * t);
        x[std::size_t(n) * kTile + q] = static_cast<float>(phase.real());
        x[std::size_t(elements_ + n) * kTile + q] = static_cast<float>(phase.imag());
      }
    }
    float* y_im = y.data() + std::size_t(rows_) * kTile;
    kernels_.product(re.data(), rows_, 2 * elements_, x.data(), y.data());
    kernels_.product(im.data(), rows_, 2 * elements_, x.data(), y_im);
    for (int j = 0; j < rows_; ++j) {
      for (int q = 0; q < count; ++q) {
        const std::size_t at = std::size_t(j) * kTile + q;
        const double heard =
            element_pattern(grid_.node_u(first + q), setup_.sonar.array->element_width_m,
                            wavelength_m(setup_.sonar, setup_.water));
        packed[(std::size_t(j / kRowBlock) * grid_.nodes + first + q) * kRowBlock + j % kRowBlock] =
            (y[at] * y[at] + y_im[at] * y_im[at]) * static_cast<float>(heard * heard);
      }
    }
  }
  return packed;
}

struct PowerScratch {
  EchoBuffer echoes;
  AlignedBuffer<float> planes;
  std::vector<std::uint32_t> offset, next;
  // Echoes before they are sorted.
  struct Echo {
    double delay_s;
    float power;
    std::int32_t cell;
  };
  std::vector<Echo> unsorted;
};

// Sums the power of echoes at nodes in u, and beams from the nodes by their power patterns.
class NodePower final : public ArrayPower {
 public:
  explicit NodePower(const SynthesisTables& tables)
      : setup_(tables.setup),
        kernels_(kernels_of(setup_.simd)),
        grid_(make_power_grid(setup_)),
        plan_(make_array_power_plan(tables, grid_)) {}

  SynthesisMemory memory() const override;
  void diffuse(const PingTask& task, SampleArray<float>& power,
               const Workers& workers) const override;

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int samples() const { return setup_.record.samples; }

  template <class Body>
  void for_each_echo(const PingTask& task, Body&& body) const;
  void sort_echoes(const PingTask& task, PowerScratch& scratch) const;
  void add_up(const PatternBlock& block, const PowerScratch& scratch, SampleArray<float>& power,
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

// Calls body(u, delay_s, power) for the diffuse part of all scatterers and for volumes.
template <class Body>
void NodePower::for_each_echo(const PingTask& task, Body&& body) const {
  const Sonar& sonar = setup_.sonar;
  const double source_pa_m = source_pressure_pa_m(sonar);
  for (const Scatterer& s : task.scatterers->items) {
    if (s.standard_deviation == 0) continue;
    const double a = source_pa_m * s.standard_deviation * s.gain;
    body(arrival_cosine(s), s.delay_s, a * a);
  }
  for (int j = 0; !task.volumes.empty() && j < beams(); ++j) {
    const double u = std::sin(beam_azimuth_rad(sonar, j));
    for (int n = 0; n < samples(); ++n) {
      const double energy = total_energy(task.volumes, std::size_t(j) * samples() + n);
      if (energy > 0) body(u, n / sonar.bandwidth_hz, source_pa_m * source_pa_m * energy);
    }
  }
}

// Sorts echoes by cells of u, and keeps their order within a cell. Sums follow this order.
void NodePower::sort_echoes(const PingTask& task, PowerScratch& scratch) const {
  scratch.offset.assign(grid_.cells + 1, 0);
  scratch.unsorted.clear();
  for_each_echo(task, [&](double u, double delay_s, double power) {
    const int cell = grid_.cell_of(u);
    ++scratch.offset[cell + 1];
    scratch.unsorted.push_back({delay_s, static_cast<float>(power), cell});
  });
  for (int c = 0; c < grid_.cells; ++c) scratch.offset[c + 1] += scratch.offset[c];
  scratch.next.assign(scratch.offset.begin(), scratch.offset.end() - 1);
  EchoBuffer& echoes = scratch.echoes;
  const std::size_t count = scratch.offset.back();
  echoes.value.need(2 * count);
  echoes.offset.need(count);
  echoes.first.need(count);
  echoes.delay.need(count);
  echoes.has_echoes = count > 0;
  for (const PowerScratch::Echo& echo : scratch.unsorted) {
    const std::size_t at = scratch.next[echo.cell]++;
    echoes.value[2 * at] = echoes.value[2 * at + 1] = echo.power;
    echoes.delay[at] = echo.delay_s;
  }
  kernels_.place(setup_.sonar.bandwidth_hz / plan_->transform, plan_->grid.spread.points,
                 plan_->grid.spread.width, echoes.delay.data(), static_cast<int>(count),
                 echoes.first.data(), echoes.offset.data());
}

void NodePower::add_up(const PatternBlock& block, const PowerScratch& scratch,
                       SampleArray<float>& power, const Workers& workers) const {
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
  memory.echo_bytes =
      3 * sizeof(float) + sizeof(std::int32_t) + sizeof(double) + sizeof(PowerScratch::Echo);
  memory.thread_bytes =
      scratch_bytes(*plan_, false) + std::uint64_t(beams() + kRowBlock) * kTile * sizeof(float);
  return memory;
}

void NodePower::diffuse(const PingTask& task, SampleArray<float>& power,
                        const Workers& workers) const {
  power.assign(std::size_t(beams()) * samples(), 0.0f);
  auto scratch = ping_pool_.take();
  sort_echoes(task, *scratch);
  if (!scratch->echoes.has_echoes) return;
  std::call_once(patterns_made_, [&] { patterns_ = make_patterns(setup_, kernels_, grid_); });
  transform_nodes(*plan_, kernels_, whole_set(*plan_, scratch->echoes, scratch->offset),
                  scratch->echoes, node_pool_, workers, scratch->planes);
  for (const PatternBlock& block : patterns_) add_up(block, *scratch, power, workers);
}

}  // namespace

int PowerGrid::cell_of(double u) const {
  const double at = (u / spacing_u - first - 1) * kCellsPerNode;
  return std::clamp(static_cast<int>(at), 0, cells - 1);
}

PowerGrid make_power_grid(const SynthesisSetup& setup) {
  const Sonar& sonar = setup.sonar;
  PowerGrid grid;
  const double aperture =
      sonar.array->elements * sonar.array->spacing_m / wavelength_m(setup.sonar, setup.water);
  grid.spacing_u = 1 / (kNodesPerLobe * std::max(aperture, 1.0));
  // All echoes come from beam cells of the fan.
  const double half_fan = furthest_azimuth_rad(sonar);
  const double furthest = half_fan < kPi / 2 ? std::sin(half_fan) : 1.0;
  grid.first = -static_cast<int>(std::ceil(furthest / grid.spacing_u)) - 2;
  grid.nodes = 2 * (-grid.first + 1);
  grid.cells = (grid.nodes - kPatternTaps + 1) * kCellsPerNode;
  return grid;
}

std::unique_ptr<const NodePlan> make_array_power_plan(const SynthesisTables& tables,
                                                      const PowerGrid& grid) {
  // The plan for ideal beam cells makes the same time series. Only its nodes differ.
  Mixing one{{1.0}, {1.0}};
  std::unique_ptr<NodePlan> plan = make_power_plan(tables.setup, one, tables.autospectrum);
  plan->nodes = {};
  fill_cells(grid, plan->nodes);
  plan->weight.assign(plan->nodes.weight.begin(), plan->nodes.weight.end());
  plan->rows = grid.nodes / 2;
  plan->even.clear();
  plan->odd.clear();
  if (tables.setup.sonar.array->steering == Steering::phase) {
    fill_row_filters(tables, grid, *plan);
  }
  return plan;
}

double PatternBlock::middle() const {
  return std::max(1.0, std::sqrt(std::max(begin, 1) * static_cast<double>(end)));
}

std::vector<PatternBlock> pattern_blocks(const SynthesisSetup& setup) {
  const ArrayReceiver& array = *setup.sonar.array;
  const double end_m = (array.elements - 1) / 2.0 * array.spacing_m;
  const double per_sample = setup.water.sound_speed_m_s / (2 * setup.sonar.bandwidth_hz);
  // The phase due to curvature is bend / sample.
  const double bend = kPi * end_m * end_m / (wavelength_m(setup.sonar, setup.water) * per_sample);
  std::vector<PatternBlock> blocks;
  for (int end = setup.record.samples; end > 0;) {
    const double phase = bend / end;
    double nearest = end / kFocusedRatio;
    if (array.focus == Focus::none) {
      nearest = std::min(end / kRangeRatio, bend / (phase + kBendRad));
    }
    const int begin = std::clamp(static_cast<int>(std::ceil(nearest)), 0, end - 1);
    // At ranges below the length of the array, the approximation does not hold at all.
    blocks.push_back({per_sample * end < 2 * end_m ? 0 : begin, end, {}});
    end = blocks.back().begin;
  }
  return blocks;
}

std::vector<PatternBlock> make_patterns(const SynthesisSetup& setup, const Kernels& kernels,
                                        const PowerGrid& grid) {
  const PatternMaker maker(setup, kernels, grid);
  std::vector<PatternBlock> blocks = pattern_blocks(setup);
  for (PatternBlock& block : blocks) {
    block.packed = maker.patterns(block.middle());
  }
  return blocks;
}

std::uint64_t pattern_bytes(const SynthesisSetup& setup, const PowerGrid& grid) {
  return pattern_blocks(setup).size() * std::uint64_t(setup.sonar.beam_count + kRowBlock) *
         grid.nodes * sizeof(float);
}

std::unique_ptr<const ArrayPower> make_array_power(const SynthesisTables& tables) {
  return std::make_unique<NodePower>(tables);
}

}  // namespace ensonify
