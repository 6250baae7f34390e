#include <algorithm>

#include "synthesis/cpu/array_nodes.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kCacheBlock = 64;  // samples of all nodes that stay in a core's cache
constexpr int kBeamsAtOnce = 64;

double* as_doubles(Complex* p) { return reinterpret_cast<double*>(p); }

std::int64_t plane_stride(const ArrayPlan& plan) { return (plan.samples() + 63) / 64 * 64 + 64; }

// Spectra of all nodes at the bins of one block.
void steer_block(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels,
                 const AlignedBuffer<Complex>& spectra, std::size_t b, SteerScratch& scratch,
                 AlignedBuffer<Complex>& out) {
  const SteerBlock& block = nodes.blocks[b];
  const int elements = plan.elements(), bins = plan.bins();
  const std::size_t width = nodes.block_bins, size = nodes.grid * width;
  scratch.elements.need(size);
  scratch.record.need(nodes.rows * width);
  Complex* rows = scratch.elements.data();
  std::fill_n(rows, size, Complex(0));
  double part_of_band[kSteerBins];
  for (int i = 0; i < block.count; ++i) {
    const int bin = block.first + i;
    part_of_band[i] = 2.0 * (bin < bins / 2 ? bin : bin - bins) / bins;
  }
  for (int n = 0; n < elements; ++n) {
    const int row = (n - elements / 2 + nodes.grid) % nodes.grid;
    const Complex* from = spectra.data() + std::size_t(n) * bins + block.first;
    const double* w = nodes.element_weight.data() + std::size_t(4) * n;
    Complex* to = rows + row * width;
    for (int i = 0; i < block.count; ++i) {
      const double x = part_of_band[i];
      to[i] = (((w[0] * x + w[1]) * x + w[2]) * x + w[3]) * from[i];
    }
  }
  nodes.along.run(rows);
  Complex* reached = scratch.record.data();
  for (int r = 0; r < nodes.rows; ++r) {
    const int wrapped = ((nodes.first_row + r) % nodes.grid + nodes.grid) % nodes.grid;
    const double re = nodes.row_phase[r].real(), im = nodes.row_phase[r].imag();
    const double* from = as_doubles(rows + wrapped * width);
    double* to = as_doubles(reached + r * width);
    for (int i = 0; i < nodes.block_bins; ++i) {
      to[2 * i] = re * from[2 * i] - im * from[2 * i + 1];
      to[2 * i + 1] = re * from[2 * i + 1] + im * from[2 * i];
    }
  }
  alignas(64) double time[2 * kSteerBins];
  for (int i = 0; i < block.count; ++i) {
    time[2 * i] = time[2 * i + 1] = (2 * i + 1.0 - block.count) / nodes.block_bins;
  }
  const std::size_t blocks = nodes.blocks.size();
  for (int q = 0; q < nodes.count; ++q) {
    const std::size_t at = q * blocks + b;
    kernels.array_steer(as_doubles(reached + nodes.base[at] * width), 2 * nodes.block_bins,
                        nodes.weight.data() + at * kSteerTaps * (kSteerDegree + 1), time,
                        block.count, as_doubles(out.data() + std::size_t(q) * bins + block.first));
  }
}

void node_series(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels, int node,
                 SteerScratch& scratch, NodeRecords& records) {
  const int bins = plan.bins();
  const std::int64_t stride = plane_stride(plan);
  scratch.record.need(bins);
  const Complex* spectrum = records.spectra.data() + std::size_t(node) * bins;
  for (int order = 0; order < nodes.orders; ++order) {
    const double* factor = nodes.order_factor.data() + std::size_t(order) * bins;
    for (int k = 0; k < bins; ++k) scratch.record[k] = factor[k] * spectrum[k];
    plan.record_backward.run(scratch.record.data());
    float* re = records.planes.data() + (std::int64_t{2} * order * nodes.count + node) * stride;
    kernels.narrow(as_doubles(scratch.record.data()), plan.samples(), re,
                   re + nodes.count * stride);
  }
}

struct Piece {
  const NodeStretch* stretch;
  int first, count;  // samples
};

void sum_piece(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels,
               const NodeRecords& records, const Piece& piece, const float* time, int beam,
               std::complex<float>* out) {
  const NodeStretch& s = *piece.stretch;
  const std::int64_t stride = plane_stride(plan);
  alignas(64) float re[kCacheBlock] = {}, im[kCacheBlock] = {};
  const int padded = (piece.count + 15) / 16 * 16;
  const std::size_t size = std::size_t(s.taps) * (s.degree + 1) * 2;
  for (int order = 0; order < s.orders; ++order) {
    const float* from = records.planes.data() +
                        (std::int64_t{2} * order * nodes.count + s.first[beam]) * stride +
                        piece.first;
    const NodeSum sum = {s.coefficient.data() + (std::size_t(beam) * s.orders + order) * size,
                         s.taps,
                         s.degree,
                         from,
                         from + nodes.count * stride,
                         stride};
    kernels.array_nodes(&sum, time, padded, re, im);
  }
  for (int t = 0; t < piece.count; ++t) out[t] = {re[t], im[t]};
}

}  // namespace

void node_beams(const ArrayPlan& plan, const ArrayNodes& nodes, const Kernels& kernels,
                const AlignedBuffer<Complex>& spectra, Pool<SteerScratch>& pool,
                const Workers& workers, NodeRecords& records, std::complex<float>* series) {
  records.spectra.need(std::size_t(nodes.count) * plan.bins());
  records.planes.need(2 * std::size_t(nodes.orders) * nodes.count * plane_stride(plan));
  workers.for_each(nodes.blocks.size(), [&](std::size_t b) {
    auto scratch = pool.take();
    steer_block(plan, nodes, kernels, spectra, b, *scratch, records.spectra);
  });
  workers.for_each(nodes.count, [&](std::size_t q) {
    auto scratch = pool.take();
    node_series(plan, nodes, kernels, static_cast<int>(q), *scratch, records);
  });
  std::vector<Piece> pieces;
  for (const NodeStretch& s : nodes.stretches) {
    for (int n = s.begin; n < s.end; n += kCacheBlock) {
      pieces.push_back({&s, n, std::min(kCacheBlock, s.end - n)});
    }
  }
  const int slabs = (plan.beams() + kBeamsAtOnce - 1) / kBeamsAtOnce;
  workers.for_each(pieces.size() * slabs, [&](std::size_t item) {
    const Piece& piece = pieces[item / slabs];
    const int first = static_cast<int>(item % slabs) * kBeamsAtOnce;
    alignas(64) float time[kCacheBlock];
    for (int t = 0; t < kCacheBlock; ++t) {
      const bool moves = piece.stretch->degree > 0;
      time[t] = moves ? static_cast<float>(piece.stretch->time(piece.first + t)) : 0.0f;
    }
    for (int beam = first; beam < std::min(first + kBeamsAtOnce, plan.beams()); ++beam) {
      sum_piece(plan, nodes, kernels, records, piece, time, beam,
                series + std::size_t(beam) * plan.samples() + piece.first);
    }
  });
}

std::uint64_t node_ping_bytes(const ArrayPlan& plan, const ArrayNodes& nodes) {
  return std::uint64_t(nodes.count) * plan.bins() * sizeof(Complex) +
         2 * std::uint64_t(nodes.orders) * nodes.count * plane_stride(plan) * sizeof(float);
}

std::uint64_t node_thread_bytes(const ArrayPlan& plan, const ArrayNodes& nodes) {
  return (std::uint64_t(nodes.grid + nodes.rows) * nodes.block_bins + plan.bins()) *
         sizeof(Complex);
}

}  // namespace ensonify
