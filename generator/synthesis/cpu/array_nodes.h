// Forms beams from nodes. The elements' records are steered to a few equally spaced directions, the
// nodes, and beams are short sums of neighboring nodes.
//
// The record of node q at u = (first + q) spacing_u is
//   z_q(t) = sum_n weight_n / node_taper e^(i 2 pi f_c D_nq) p_n(t + D_nq)   (by phase: p_n(t)),
// which is a nonuniform transform along the elements for every frequency f_c + nu. A beam between
// nodes is a sum of them. So is a focused beam, because the chirp of the focus across the array is
// a convolution over u. With steering by delay the width of this chirp depends on the frequency,
// which `orders` Chebyshev polynomials of nu represent.
//
//   NodeStretch  choose_stretches   a stretch of samples with its coefficients
//   ArrayNodes   make_array_nodes   node_table_bytes
//   node_beams   node_ping_bytes  node_thread_bytes
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "synthesis/cpu/array_records.h"

namespace ensonify {

struct NodeStretch {
  int begin = 0, end = 0;  // samples
  int orders = 0, taps = 0, degree = 0;
  std::vector<float> coefficient;  // [beams][orders][taps][degree + 1][re, im]
  std::vector<int> first;          // [beams], node of the first tap

  // The polynomials' variable, -1 .. 1 over the stretch. Like the focus, it is linear in 1 / range.
  double time(double sample) const {
    const double near = 1.0 / begin, far = 1.0 / (end - 1);
    return (2 / sample - near - far) / (near - far);
  }
};

// Bins [first, first + count), at most block_bins, on one side of the carrier.
struct SteerBlock {
  int first, count;
};

struct ArrayNodes {
  ArrayNodes(int grid_rows, int bins)
      : grid(grid_rows), block_bins(bins), along(grid_rows, bins, FftDirection::forward) {}

  double spacing_u = 0;
  int first = 0, count = 0;
  int orders = 1;
  int near_samples = 0;  // the first samples, which no stretch contains
  std::vector<NodeStretch> stretches;

  // The transform along the elements, with `grid` points per turn from element to element.
  int grid = 0, first_row = 0, rows = 0;  // rows that nodes reach; first_row may be negative
  int block_bins = 0;                     // so few that nodes hardly move on the grid
  std::vector<SteerBlock> blocks;
  // [elements][4]: polynomials of nu / (b/2), constant term last.
  std::vector<double> element_weight;
  std::vector<std::complex<double>> row_phase;  // [rows]
  std::vector<std::int32_t> base;               // [count][blocks], row of the first tap
  AlignedBuffer<double> weight;                 // [count][blocks][taps][degree + 1]
  std::vector<double> order_factor;             // [orders][bins]
  BatchFft along;
};

// The transform of the window that spreads a beam over nodes. Elements are divided by it, so that a
// few nodes suffice for a beam. x: turns of an element's phase from node to node.
double node_taper(double x);

// Null if nodes do not make beams faster.
std::shared_ptr<const ArrayNodes> make_array_nodes(const ArrayPlan& plan);

struct SteerScratch {
  AlignedBuffer<std::complex<double>> elements, record;
};

struct NodeRecords {
  AlignedBuffer<std::complex<double>> spectra;  // [count][bins]
  AlignedBuffer<float> planes;                  // [orders][re, im][count][stride]
};

// Writes the samples from near_samples on of all beams to series [beams][plan.samples()].
void node_beams(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels,
                const AlignedBuffer<std::complex<double>>& spectra, Pool<SteerScratch>& pool,
                const Workers& workers, NodeRecords& records, std::complex<float>* series);

std::uint64_t node_table_bytes(const ArrayNodes& nodes);
std::uint64_t node_ping_bytes(const ArrayPlan& plan, const ArrayNodes& nodes);
std::uint64_t node_thread_bytes(const ArrayPlan& plan, const ArrayNodes& nodes);

// Chooses stretches from the last sample down to the one where nodes stop being faster. Needs
// nodes.spacing_u. Sets stretches, orders and near_samples.
void choose_stretches(const ArrayPlan& plan, ArrayNodes& nodes);

}  // namespace ensonify
