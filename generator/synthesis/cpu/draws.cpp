#include "synthesis/cpu/draws.h"

#include <algorithm>
#include <cstring>

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr std::int64_t kCellFloats = 2 * kDraws;  // of one grid point or sample of all draws

// The spectra of the draws of one row. An odd number of cache lines lies between two of them, so
// that they do not take one place in the cache.
std::int64_t spectrum_stride(int length) { return (length + 7) / 8 * 8 + 4; }

struct DrawGroup {
  int first = 0, last = 0;                        // rows
  std::int64_t grid_floats = 0, cell_floats = 0;  // of a row
};

DrawGroup group_of(const NodePlan& plan, std::size_t item) {
  DrawGroup group;
  group.first = static_cast<int>(item) * kGroup;
  group.last = std::min(group.first + kGroup, plan.rows);
  group.grid_floats = kDraws * grid_stride(plan.grid);
  group.cell_floats = kCellFloats * plan.samples;
  return group;
}

// False if the group hears no echo, and its grids are left as they were.
bool deposit_group(const NodePlan& plan, const Kernels& kernels, const EchoArrays& echoes,
                   std::span<const std::uint32_t> beam_offset, const DrawGroup& group,
                   NodeScratch& scratch) {
  const KernelPolynomial kernel = plan.grid.spread.polynomial();
  scratch.grid.need(kGroup * group.grid_floats);
  float* grids = scratch.grid.data();
  bool has_echoes = false;
  Reach reach;
  for (int beam = 0; beam < plan.nodes.beams; ++beam) {
    if (beam_offset[beam] == beam_offset[beam + 1]) continue;
    reach_of(plan, beam, group.first, group.last, reach);
    if (reach.count == 0) continue;
    if (!has_echoes) std::memset(grids, 0, kGroup * group.grid_floats * sizeof(float));
    has_echoes = true;
    kernels.deposit_draws(&echoes, beam_offset[beam], beam_offset[beam + 1], &kernel,
                          plan.grid.spread.width, reach.weight, reach.count,
                          grids + reach.first * group.grid_floats, group.grid_floats);
  }
  return has_echoes;
}

void deposit_group_cells(const NodePlan& plan, const Kernels& kernels, const EchoBuffer& echoes,
                         const DrawGroup& group, NodeScratch& scratch) {
  scratch.cell_rows.need(kGroup * group.cell_floats);
  float* rows = scratch.cell_rows.data();
  std::memset(rows, 0, kGroup * group.cell_floats * sizeof(float));
  Reach reach;
  for (int beam = 0; beam < plan.nodes.beams; ++beam) {
    reach_of(plan, beam, group.first, group.last, reach);
    for (int r = 0; r < reach.count; ++r) {
      kernels.add_scaled(reach.weight + 2 * r, echoes.cells.data() + beam * group.cell_floats,
                         static_cast<int>(group.cell_floats),
                         rows + (reach.first + r) * group.cell_floats);
    }
  }
}

}  // namespace

void transform_draws(const NodePlan& plan, const Kernels& kernels, EchoBuffer& echoes,
                     std::span<const std::uint32_t> beam_offset, Pool<NodeScratch>& pool,
                     const Workers& workers, AlignedBuffer<float>& planes) {
  ENSONIFY_ASSERT(echoes.draws == kDraws && plan.segments == 2);
  const EchoArrays arrays = echoes.arrays();
  const std::int64_t stride = plan.plane_stride();
  const std::int64_t of_points = spectrum_stride(plan.grid.spread.points);
  const std::int64_t of_bins = spectrum_stride(plan.transform);
  planes.need(2 * kDraws * plan.rows * stride);
  workers.for_each((plan.rows + kGroup - 1) / kGroup, [&](std::size_t item) {
    auto scratch = pool.take();
    const DrawGroup group = group_of(plan, item);
    const bool has_echoes =
        echoes.has_echoes && deposit_group(plan, kernels, arrays, beam_offset, group, *scratch);
    if (echoes.has_cells) deposit_group_cells(plan, kernels, echoes, group, *scratch);
    scratch->spectrum.need(kDraws * of_points);
    if (echoes.has_cells) scratch->cell_spectrum.need(kDraws * of_bins);
    scratch->record.need(plan.transform);
    Complex* record = scratch->record.data();
    for (int row = group.first; row < group.last; ++row) {
      if (has_echoes) {
        kernels.widen_draws(scratch->grid.data() + (row - group.first) * group.grid_floats,
                            plan.grid.spread.points, kHalo, as_doubles(scratch->spectrum.data()),
                            2 * of_points);
      }
      if (echoes.has_cells) {
        kernels.widen_draws(scratch->cell_rows.data() + (row - group.first) * group.cell_floats,
                            plan.samples, 0, as_doubles(scratch->cell_spectrum.data()),
                            2 * of_bins);
      }
      for (int draw = 0; draw < kDraws; ++draw) {
        float* out = planes.data() + 2 * (std::int64_t{draw} * plan.rows + row) * stride;
        if (!has_echoes && !echoes.has_cells) {
          std::memset(out, 0, 2 * stride * sizeof(float));
          continue;
        }
        if (has_echoes) {
          filter_grid(plan, kernels, plan.grid, row, false,
                      scratch->spectrum.data() + draw * of_points, record);
        } else {
          std::memset(as_doubles(record), 0, 2 * sizeof(double) * plan.transform);
        }
        if (echoes.has_cells) {
          add_cells(plan, kernels, scratch->cell_spectrum.data() + draw * of_bins, record);
        }
        plan.backward.run(record);
        kernels.narrow(as_doubles(record), plan.samples, out, out + stride);
      }
    }
  });
}

}  // namespace ensonify
