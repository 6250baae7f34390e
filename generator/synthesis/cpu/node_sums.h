// The fast path: echoes are spread over a few nodes across the fan and over a time grid, each
// node's record is transformed and filtered, and beams are sums of a few nodes.
//
//   nodes_of           the nodes of a mixing
//   GridFilter         make_series_filter
//   NodePlan           make_series_plan  make_power_plan   what all pings of one setup share
//   EchoBuffer         the deposited values of one ping
//   EchoSet            echoes that share a grid
//   series_echoes      a gain e^(-i 2 pi f_c tau) S0, with a drawn or its mean
//   power_echoes       S0^2 variance gain^2
//   NodeScratch        the memory of one worker
//   Reach  reach_of  grid_stride  filter_grid  add_cells   the steps from echoes to a record
//   transform_nodes    echoes -> records of nodes
//   mix_tile           records of nodes -> mixed nodes, kTile floats of time at once
//   beam_tile          mixed nodes -> a beam
#pragma once

#include <atomic>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/beam_nodes.h"
#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/fft.h"

namespace ensonify {

// The nodes for weights and scales, or for their squares. The weights of equal beams are without
// the scales. tolerance, row_cost: as in beam_nodes.h.
BeamNodes nodes_of(const Mixing& mixing, bool squared, double tolerance, double row_cost);

// The time grid for the echoes of one pulse, and what its spectrum is multiplied by.
struct GridFilter {
  SpreadKernel spread;
  ComplexFft forward;
  AlignedBuffer<std::complex<double>> lower, upper;  // [M], for both parts of a grid's spectrum
};

// Empty if no kernel holds the tolerance of the time series.
std::unique_ptr<GridFilter> make_series_filter(const std::vector<std::complex<double>>& spectrum,
                                               double tolerance);

// A row is one complex record. For series it contains one node, and its two planes are re and im.
// For power, whose values are real, it contains two nodes, one per plane.
struct NodePlan {
  BeamNodes nodes;
  GridFilter grid;
  int samples = 0, transform = 0;
  int rows = 0;
  int segments = 0;           // planes of one node in a tile: 2 (series) or 1 (power)
  std::vector<float> weight;  // [beams][width]: P, for the deposit
  // Of equal beams, P with each beam's 1 / N_j (power: squared), and K folded about the fan's
  // middle, packed for product().
  std::vector<float> out_weight, even, odd;
  std::vector<float> rows_of_beams;                 // of unequal beams, R packed for product()
  AlignedBuffer<std::complex<double>> cell_filter;  // [M], for echoes at whole samples
  // [rows][2][M]: both parts of the filter of each row if rows differ; otherwise empty.
  std::vector<std::complex<double>> row_filter;
  ComplexFft cell_forward, backward;

  // Floats from plane to plane, rounded up to whole tiles.
  std::int64_t plane_stride() const { return (samples + kTile - 1) / kTile * std::int64_t{kTile}; }
  // Samples of a beam in one tile.
  int tile_samples() const { return kTile / segments; }
};

// Null if no kernel holds the tolerance. The tolerance of powers is fixed.
std::unique_ptr<NodePlan> make_series_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                           const std::vector<std::complex<double>>& spectrum,
                                           double tolerance);
std::unique_ptr<NodePlan> make_power_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                          const std::vector<std::complex<double>>& autospectrum);

// Echoes in the order of the scatterers, and cells, which are complex numbers at whole samples.
struct EchoBuffer {
  int draws = 1;                       // of the amplitudes, next to each other: 1 or kDraws
  AlignedBuffer<float> value, offset;  // [echoes][draws] complex, [echoes]
  AlignedBuffer<std::int32_t> first;
  AlignedBuffer<float> cells;  // [beams][samples][draws] complex
  bool keeps_shift = false;    // whether to fill the next two
  AlignedBuffer<double> delay;
  AlignedBuffer<float> doppler;
  bool has_echoes = false, has_cells = false;
  // Whether any scatterer has a mean or a diffuse part, as found when echoes are gathered.
  std::atomic<bool> has_means = false, has_diffuse = false;

  EchoArrays arrays() { return {value.data(), first.data(), offset.data()}; }
};

// Echoes that share a grid. Those of beam cell j are [begin[j], end[j]).
struct EchoSet {
  const GridFilter* grid = nullptr;
  EchoArrays arrays{};
  std::span<const std::uint32_t> begin, end;
};

// All echoes of a list, sorted by beam cell; none if the buffer has none.
inline std::vector<EchoSet> whole_set(const NodePlan& plan, EchoBuffer& echoes,
                                      std::span<const std::uint32_t> beam_offset) {
  if (!echoes.has_echoes) return {};
  return {{&plan.grid, echoes.arrays(), beam_offset, beam_offset.subspan(1)}};
}

struct NodeScratch {
  AlignedBuffer<float> grid, cell_rows, tile, beams;
  AlignedBuffer<std::complex<double>> spectrum, cell_spectrum, record;
};

// The rows of one work item. Their grids fit into a core's own cache, and an echo's kernel is
// computed once for all of them.
inline constexpr int kGroup = 8;

// The rows of a group that a beam reaches, with the weights for deposit().
struct Reach {
  int first = 0, count = 0;
  float weight[kGroup * 2];
};
void reach_of(const NodePlan& plan, int beam, int first_row, int last_row, Reach& reach);

// The floats of a row of a grid.
inline std::int64_t grid_stride(const GridFilter& grid) {
  return 2 * (grid.spread.points + 2 * kHalo);
}

// Transforms the grid of a row, [points of the filter], and writes its filtered spectrum to
// `record`, [transform], or adds it.
void filter_grid(const NodePlan& plan, const Kernels& kernels, const GridFilter& filter, int row,
                 bool adds, std::complex<double>* grid, std::complex<double>* record);
// Adds the filtered spectrum of a row's cells, whose buffer has the length of the record.
void add_cells(const NodePlan& plan, const Kernels& kernels, std::complex<double>* cells,
               std::complex<double>* record);

// Adds up the records of all sets, and the cells of the buffer. planes: [2 rows][plane_stride] of
// the plan. They stay zero after the last sample.
void transform_nodes(const NodePlan& plan, const Kernels& kernels, std::span<const EchoSet> sets,
                     const EchoBuffer& cells, Pool<NodeScratch>& pool, const Workers& workers,
                     AlignedBuffer<float>& planes);

// The nodes of samples [tile * tile_samples ...), [nodes][kTile], valid until the scratch is used
// for another tile. Those of equal beams are mixed.
const float* mix_tile(const NodePlan& plan, const Kernels& kernels, const float* planes, int tile,
                      NodeScratch& scratch);

// The tile of a beam, [kTile], from the nodes of mix_tile. Call it for beams 0, 1, 2 ... with the
// same scratch. The tile is valid until the next call.
const float* beam_tile(const NodePlan& plan, const Kernels& kernels, const float* mixed, int beam,
                       NodeScratch& scratch);

// The memory of the plan, of `planes`, and of the scratch of one worker.
std::uint64_t plan_bytes(const NodePlan& plan);
std::uint64_t planes_bytes(const NodePlan& plan);
std::uint64_t scratch_bytes(const NodePlan& plan, bool has_cells, std::uint64_t sets = 1);

// Plain arrays of a few hundred scatterers, because kernels accept only these.
struct EchoScratch {
  static constexpr int kCount = kPathChunk;
  double delay_s[kCount];
  std::uint32_t key_low[kCount], key_high[kCount];
  float mean_re[kCount], mean_im[kCount], deviation[kCount], gain[kCount];
  float normal_re[kCount], normal_im[kCount];
  PathFactors path;
};

enum class EchoAmplitude { drawn, mean };

bool has_means(const PingTask& task);

// Of one task, or of up to kDraws tasks with the same scatterers and volumes.
void series_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                   std::span<const PingTask> tasks, EchoAmplitude amplitude,
                   Pool<EchoScratch>& pool, const Workers& workers, EchoBuffer& echoes);
void power_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                  const PingTask& task, Pool<EchoScratch>& pool, const Workers& workers,
                  EchoBuffer& echoes);

}  // namespace ensonify
