// Beams through nodes: the elements' records steered to few equally spaced directions, and beams as
// short sums of neighbouring nodes.
//
// At node q, u = (first + q) spacing_u, stands
//   z_q(t) = sum_n weight_n / node_taper e^(i 2 pi f_c D_nq) p_n(t + D_nq)   (by phase: p_n(t))
// for every frequency f_c + nu a nonuniform transform along the elements. A beam between nodes is
// a sum of them, and so is a focused one, whose chirp across the array is a convolution over u.
// Steering by delay turns the chirp's width with frequency: `orders` Chebyshev polynomials of nu
// carry that.
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

  // -1 .. 1 over the stretch, linear in one over the range, as the focus is.
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
  int near_samples = 0;  // that no stretch holds
  std::vector<NodeStretch> stretches;

  // The transform along the elements: `grid` points of a turn from element to element.
  int grid = 0, first_row = 0, rows = 0;  // rows that nodes reach; first_row may be negative
  int block_bins = 0;                     // few enough that nodes hardly move over the grid
  std::vector<SteerBlock> blocks;
  // [elements][4]: polynomial of nu / (b/2), constant term last.
  std::vector<double> element_weight;
  std::vector<std::complex<double>> row_phase;  // [rows]
  std::vector<std::int32_t> base;               // [count][blocks], row of the first tap
  AlignedBuffer<double> weight;                 // [count][blocks][taps][degree + 1]
  std::vector<double> order_factor;             // [orders][bins]
  BatchFft along;
};

// The transform of the window that spreads a beam over nodes: with the elements divided by it a few
// nodes serve. x: turns of an element from node to node.
double node_taper(double x);

// None where nodes do not pay.
std::shared_ptr<const ArrayNodes> make_array_nodes(const ArrayPlan& plan);

struct SteerScratch {
  AlignedBuffer<std::complex<double>> elements, record;
};

struct NodeRecords {
  AlignedBuffer<std::complex<double>> spectra;  // [count][bins]
  AlignedBuffer<float> planes;                  // [orders][re, im][count][stride]
};

// Samples from near_samples on, of all beams.
void node_beams(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels,
                const AlignedBuffer<std::complex<double>>& spectra, Pool<SteerScratch>& pool,
                const Workers& workers, NodeRecords& records, std::complex<float>* series);

std::uint64_t node_table_bytes(const ArrayNodes& nodes);
std::uint64_t node_ping_bytes(const ArrayPlan& plan, const ArrayNodes& nodes);
std::uint64_t node_thread_bytes(const ArrayPlan& plan, const ArrayNodes& nodes);

// Stretches from the last sample down to where nodes stop to pay: nodes.spacing_u must be set; sets
// stretches, orders and near_samples.
void choose_stretches(const ArrayPlan& plan, ArrayNodes& nodes);

}  // namespace ensonify
