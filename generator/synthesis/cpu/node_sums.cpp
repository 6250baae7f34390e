#include "synthesis/cpu/node_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/sonar.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// The transform of one sample of a plane costs about as much as this number of products in mixing.
constexpr double kRowCost = 325;
// The shares of the tolerance for kernel and nodes, whose errors add by squares. The limit for
// tails usually makes the kernel more accurate than its share.
constexpr double kKernelShare = 0.4, kNodeShare = 0.3;
// Expected power is shown in decibels, where side lobes far below a strong echo are still visible.
constexpr double kPowerTolerance = 3e-6;

// Whether the band ends with a step. Then an echo at a whole sample has no tail except for rounding
// errors of single precision.
bool has_sharp_edges(const std::vector<Complex>& spectrum) {
  double largest = 0;
  for (const Complex& s : spectrum) largest = std::max(largest, std::abs(s));
  return std::max(std::abs(spectrum.front()), std::abs(spectrum.back())) > 0.1 * largest;
}

// value(row, column) of a matrix -> [blocks of kRowBlock rows][columns][kRowBlock].
template <class Value>
std::vector<float> packed(int rows, int columns, Value&& value) {
  const int blocks = (rows + kRowBlock - 1) / kRowBlock;
  std::vector<float> result(std::size_t(blocks) * kRowBlock * columns);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t block = std::size_t(row / kRowBlock) * columns + column;
      result[block * kRowBlock + row % kRowBlock] = static_cast<float>(value(row, column));
    }
  }
  return result;
}

std::vector<float> folded(const BeamNodes& nodes, double sign) {
  const int n = nodes.nodes;
  return packed(n / 2, n / 2, [&](int c, int d) {
    const double* row = nodes.matrix.data() + std::size_t(c) * n;
    return (row[d] + sign * row[n - 1 - d]) / 2;
  });
}

GridFilter make_filter(SpreadKernel spread, int bins) {
  ComplexFft forward(spread.points, FftDirection::forward);
  return {std::move(spread), std::move(forward), AlignedBuffer<Complex>(bins),
          AlignedBuffer<Complex>(bins)};
}

std::unique_ptr<NodePlan> make_plan(const SynthesisSetup& setup, GridFilter grid, BeamNodes nodes,
                                    const std::vector<double>& scale, int segments) {
  const int bins = setup.record.transform;
  auto plan =
      std::make_unique<NodePlan>(NodePlan{.nodes = {},
                                          .grid = std::move(grid),
                                          .samples = setup.record.samples,
                                          .transform = bins,
                                          .rows = nodes.nodes * segments / 2,
                                          .segments = segments,
                                          .weight = {},
                                          .out_weight = {},
                                          .even = {},
                                          .odd = {},
                                          .rows_of_beams = {},
                                          .cell_filter = AlignedBuffer<Complex>(bins),
                                          .row_filter = {},
                                          .cell_forward = ComplexFft(bins, FftDirection::forward),
                                          .backward = ComplexFft(bins, FftDirection::backward)});
  plan->weight.assign(nodes.weight.begin(), nodes.weight.end());
  if (nodes.is_equal) {
    plan->even = folded(nodes, 1);
    plan->odd = folded(nodes, -1);
    for (std::size_t at = 0; at < nodes.weight.size(); ++at) {
      plan->out_weight.push_back(static_cast<float>(nodes.weight[at] * scale[at / nodes.width]));
    }
  } else {
    plan->rows_of_beams = packed(nodes.beams, nodes.nodes, [&](int beam, int node) {
      return nodes.matrix[std::size_t(beam) * nodes.nodes + node];
    });
  }
  nodes.matrix = {};
  plan->nodes = std::move(nodes);
  return plan;
}

struct Group {
  int first, last;  // rows
  std::int64_t cell_stride;
};

// Deposits a set on the grids of a group. False if there are no echoes, and grids are left as they
// were.
bool deposit_set(const NodePlan& plan, const Kernels& kernels, const EchoSet& set,
                 const Group& group, float* grids) {
  const KernelPolynomial kernel = set.grid->spread.polynomial();
  const std::int64_t stride = grid_stride(*set.grid);
  bool has_echoes = false;
  Reach reach;
  for (int beam = 0; beam < plan.nodes.beams; ++beam) {
    if (set.begin[beam] >= set.end[beam]) continue;
    reach_of(plan, beam, group.first, group.last, reach);
    if (reach.count == 0) continue;
    if (!has_echoes) std::memset(grids, 0, kGroup * stride * sizeof(float));
    has_echoes = true;
    kernels.deposit(&set.arrays, set.begin[beam], set.end[beam], &kernel, reach.weight, reach.count,
                    grids + reach.first * stride, stride);
  }
  return has_echoes;
}

void deposit_cells(const NodePlan& plan, const Kernels& kernels, const EchoBuffer& cells,
                   const Group& group, NodeScratch& scratch) {
  scratch.cell_rows.need(kGroup * group.cell_stride);
  std::memset(scratch.cell_rows.data(), 0, kGroup * group.cell_stride * sizeof(float));
  Reach reach;
  for (int beam = 0; beam < plan.nodes.beams; ++beam) {
    reach_of(plan, beam, group.first, group.last, reach);
    for (int r = 0; r < reach.count; ++r) {
      kernels.add_scaled(
          reach.weight + 2 * r, cells.cells.data() + std::size_t(beam) * 2 * plan.samples,
          2 * plan.samples, scratch.cell_rows.data() + (reach.first + r) * group.cell_stride);
    }
  }
}

// The grids of one set in a group.
struct SetGrids {
  const GridFilter* filter;
  const float* grids;
};

// Transforms one row of all sets and of the cells, and writes its record to scratch.record.
void transform_row(const NodePlan& plan, const Kernels& kernels, std::span<const SetGrids> sets,
                   const Group& group, bool has_cells, int row, NodeScratch& scratch) {
  Complex* record = scratch.record.data();
  if (sets.empty()) std::memset(as_doubles(record), 0, 2 * sizeof(double) * plan.transform);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const GridFilter& filter = *sets[s].filter;
    scratch.spectrum.need(filter.spread.points);
    Complex* spectrum = scratch.spectrum.data();
    kernels.widen(sets[s].grids + row * grid_stride(filter), filter.spread.points, kHalo,
                  as_doubles(spectrum));
    filter_grid(plan, kernels, filter, group.first + row, s > 0, spectrum, record);
  }
  if (has_cells) {
    Complex* spectrum = scratch.cell_spectrum.data();
    kernels.widen(scratch.cell_rows.data() + row * group.cell_stride, plan.samples, 0,
                  as_doubles(spectrum));
    add_cells(plan, kernels, spectrum, record);
  }
  plan.backward.run(record);
}

}  // namespace

BeamNodes nodes_of(const Mixing& mixing, bool squared, double tolerance, double row_cost) {
  std::vector<double> weight;
  const auto add = [&](double w) { weight.push_back(squared ? w * w : w); };
  for (const double w : mixing.weight) add(w);
  if (mixing.is_equal()) return choose_beam_nodes(weight, tolerance, row_cost);
  for (std::size_t at = 0; at < mixing.matrix.size(); ++at) {
    add(mixing.matrix[at] * mixing.scale[at / mixing.scale.size()]);
  }
  return choose_unequal_nodes(weight, mixing.middle_rad, tolerance, row_cost);
}

std::unique_ptr<GridFilter> make_series_filter(const std::vector<Complex>& spectrum,
                                               double tolerance) {
  const int bins = static_cast<int>(spectrum.size()), half = bins / 2;
  if (has_sharp_edges(spectrum)) return nullptr;
  SpreadKernel spread = choose_spread_kernel(spectrum, -half, kKernelShare * tolerance);
  if (spread.points == 0) return nullptr;
  auto grid = std::make_unique<GridFilter>(make_filter(std::move(spread), bins));
  for (int k = -half; k < half; ++k) {
    auto& filter = k < 0 ? grid->upper : grid->lower;
    filter[k < 0 ? k + bins : k] = spectrum[k + half] * grid->spread.correction[std::abs(k)];
  }
  return grid;
}

std::unique_ptr<NodePlan> make_series_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                           const std::vector<Complex>& spectrum, double tolerance) {
  std::unique_ptr<GridFilter> grid = make_series_filter(spectrum, tolerance);
  if (!grid) return nullptr;
  auto plan =
      make_plan(setup, std::move(*grid),
                nodes_of(mixing, false, kNodeShare * tolerance, 2 * kRowCost), mixing.scale, 2);
  const int bins = setup.record.transform, half = bins / 2;
  for (int k = -half; k < half; ++k) {
    plan->cell_filter[k < 0 ? k + bins : k] = spectrum[k + half];
  }
  return plan;
}

std::unique_ptr<NodePlan> make_power_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                          const std::vector<Complex>& autospectrum) {
  const int bins = setup.record.transform;
  std::vector<double> scale;
  std::vector<Complex> both_sides(2 * bins - 1);
  for (int k = 0; k < bins; ++k) {
    both_sides[bins - 1 + k] = autospectrum[k];
    both_sides[bins - 1 - k] = std::conj(autospectrum[k]);
  }
  for (const double s : mixing.scale) scale.push_back(s * s);
  SpreadKernel spread = choose_spread_kernel(both_sides, 1 - bins, kKernelShare * kPowerTolerance);
  if (spread.points == 0) return nullptr;
  auto plan =
      make_plan(setup, make_filter(std::move(spread), bins),
                nodes_of(mixing, true, kNodeShare * kPowerTolerance, 2 * kRowCost), scale, 1);
  // |s|^2 has twice the bandwidth of s. At sampling steps of 1/b, its upper half folds onto the
  // lower half.
  for (int k = 0; k < bins; ++k) {
    plan->grid.lower[k] = autospectrum[k] * plan->grid.spread.correction[k];
    plan->cell_filter[k] = autospectrum[k];
    if (k == 0) continue;
    const Complex folded = std::conj(autospectrum[bins - k]);
    plan->grid.upper[k] = folded * plan->grid.spread.correction[bins - k];
    plan->cell_filter[k] += folded;
  }
  return plan;
}

void reach_of(const NodePlan& plan, int beam, int first_row, int last_row, Reach& reach) {
  const int first_node = plan.nodes.first[beam], last_node = first_node + plan.nodes.width;
  const int per_row = 2 / plan.segments;  // nodes of one row
  const int begin = std::max(first_row, first_node / per_row);
  const int end = std::min(last_row, (last_node + per_row - 1) / per_row);
  reach.first = begin - first_row;
  reach.count = std::max(0, end - begin);
  const float* weight = plan.weight.data() + std::size_t(beam) * plan.nodes.width;
  const auto of = [&](int node) {
    return node >= first_node && node < last_node ? weight[node - first_node] : 0.0f;
  };
  for (int r = 0; r < reach.count; ++r) {
    const int node = (begin + r) * per_row;
    reach.weight[2 * r] = of(node);
    reach.weight[2 * r + 1] = of(node + per_row - 1);
  }
}

void filter_grid(const NodePlan& plan, const Kernels& kernels, const GridFilter& filter, int row,
                 bool adds, Complex* grid, Complex* record) {
  const int bins = plan.transform, points = filter.spread.points;
  filter.forward.run(grid);
  const double* spectrum = as_doubles(grid);
  const bool series = plan.segments == 2;
  const int lower = series ? bins / 2 : bins;
  const Complex* own =
      plan.row_filter.empty() ? nullptr : plan.row_filter.data() + std::size_t(row) * 2 * bins;
  const double* lower_filter = as_doubles(own ? own : filter.lower.data());
  const double* upper_filter = as_doubles(own ? own + bins : filter.upper.data());
  const auto put = adds ? kernels.multiply_add : kernels.multiply;
  put(spectrum, lower_filter, lower, as_doubles(record));
  const double* upper = spectrum + 2 * (points - bins);
  if (series) {
    put(upper + bins, upper_filter + bins, bins / 2, as_doubles(record) + bins);
  } else {
    kernels.multiply_add(upper, upper_filter, bins, as_doubles(record));
  }
}

void add_cells(const NodePlan& plan, const Kernels& kernels, Complex* cells, Complex* record) {
  const int bins = plan.transform;
  std::memset(as_doubles(cells) + 2 * plan.samples, 0, 2 * sizeof(double) * (bins - plan.samples));
  plan.cell_forward.run(cells);
  kernels.multiply_add(as_doubles(cells), as_doubles(plan.cell_filter.data()), bins,
                       as_doubles(record));
}

void transform_nodes(const NodePlan& plan, const Kernels& kernels, std::span<const EchoSet> sets,
                     const EchoBuffer& cells, Pool<NodeScratch>& pool, const Workers& workers,
                     AlignedBuffer<float>& planes) {
  const std::int64_t stride = plan.plane_stride();
  planes.need(2 * plan.rows * stride);
  std::int64_t floats = 0;
  for (const EchoSet& set : sets) floats += kGroup * grid_stride(*set.grid);
  workers.for_each((plan.rows + kGroup - 1) / kGroup, [&](std::size_t item) {
    auto scratch = pool.take();
    Group group;
    group.first = static_cast<int>(item) * kGroup;
    group.last = std::min(group.first + kGroup, plan.rows);
    group.cell_stride = 2 * plan.samples;
    scratch->grid.need(floats);
    scratch->record.need(plan.transform);
    std::vector<SetGrids> heard;
    float* grids = scratch->grid.data();
    for (const EchoSet& set : sets) {
      if (!deposit_set(plan, kernels, set, group, grids)) continue;
      heard.push_back({set.grid, grids});
      grids += kGroup * grid_stride(*set.grid);
    }
    if (cells.has_cells) {
      deposit_cells(plan, kernels, cells, group, *scratch);
      scratch->cell_spectrum.need(plan.transform);
    }
    for (int row = group.first; row < group.last; ++row) {
      float* out = planes.data() + 2 * row * stride;
      if (heard.empty() && !cells.has_cells) {
        std::memset(out, 0, 2 * stride * sizeof(float));
        continue;
      }
      transform_row(plan, kernels, heard, group, cells.has_cells, row - group.first, *scratch);
      kernels.narrow(as_doubles(scratch->record.data()), plan.samples, out, out + stride);
    }
  });
}

std::uint64_t plan_bytes(const NodePlan& plan) {
  return (plan.even.size() + plan.odd.size() + plan.rows_of_beams.size()) * sizeof(float) +
         (3 * std::uint64_t(plan.transform) + plan.row_filter.size()) *
             sizeof(std::complex<double>);
}

std::uint64_t planes_bytes(const NodePlan& plan) {
  return 2 * std::uint64_t(plan.rows) * plan.plane_stride() * sizeof(float);
}

std::uint64_t scratch_bytes(const NodePlan& plan, bool has_cells, std::uint64_t sets) {
  const std::uint64_t points = plan.grid.spread.points, bins = plan.transform;
  const std::uint64_t grids = sets * kGroup * 2 * (points + 2 * kHalo) * sizeof(float);
  const std::uint64_t records = (points + bins) * sizeof(std::complex<double>);
  const std::uint64_t tiles =
      (3 * std::uint64_t(plan.nodes.nodes) + kRowBlock) * kTile * sizeof(float);
  const std::uint64_t cells = kGroup * 2 * std::uint64_t(plan.samples) * sizeof(float) +
                              bins * sizeof(std::complex<double>);
  return grids + records + tiles + (has_cells ? cells : 0);
}

const float* mix_tile(const NodePlan& plan, const Kernels& kernels, const float* planes, int tile,
                      NodeScratch& scratch) {
  const int nodes = plan.nodes.nodes, half = nodes / 2;
  const std::int64_t first = std::int64_t{tile} * plan.tile_samples();
  if (!plan.nodes.is_equal) {
    scratch.tile.need(std::size_t(nodes) * kTile);
    const std::size_t length = plan.tile_samples();
    for (int piece = 0; piece < nodes * plan.segments; ++piece) {
      std::copy_n(planes + piece * plan.plane_stride() + first, length,
                  scratch.tile.data() + piece * length);
    }
    return scratch.tile.data();
  }
  const int padded = (half + kRowBlock - 1) / kRowBlock * kRowBlock;
  const std::size_t part = std::size_t(padded) * kTile;
  scratch.tile.need(6 * part);
  float* even = scratch.tile.data();
  float* odd = even + part;
  float* mixed_even = odd + part;
  float* mixed_odd = mixed_even + part;
  float* mixed = mixed_odd + part;
  kernels.fold(planes + first, plan.plane_stride(), plan.segments, nodes, even, odd);
  kernels.product(plan.even.data(), half, half, even, mixed_even);
  kernels.product(plan.odd.data(), half, half, odd, mixed_odd);
  kernels.unfold(mixed_even, mixed_odd, nodes, mixed);
  return mixed;
}

const float* beam_tile(const NodePlan& plan, const Kernels& kernels, const float* mixed, int beam,
                       NodeScratch& scratch) {
  const int width = plan.nodes.width, nodes = plan.nodes.nodes;
  scratch.beams.need(std::size_t(kRowBlock) * kTile);
  if (plan.nodes.is_equal) {
    kernels.combine(plan.out_weight.data() + std::size_t(beam) * width, width,
                    mixed + std::size_t(plan.nodes.first[beam]) * kTile, scratch.beams.data());
    return scratch.beams.data();
  }
  // One product makes a block of beams.
  if (beam % kRowBlock == 0) {
    kernels.product(plan.rows_of_beams.data() + std::size_t(beam) * nodes, kRowBlock, nodes, mixed,
                    scratch.beams.data());
  }
  return scratch.beams.data() + std::size_t(beam % kRowBlock) * kTile;
}

}  // namespace ensonify
