#include "synthesis/cpu/array_nodes.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "synthesis/cpu/gridding.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr double kNodeOversampling = 1.3;
constexpr int kWindow = kSteerTaps - 1;
// Arrays with fewer elements are summed directly.
constexpr int kFewestElements = 32;

constexpr double kSteerBeta = 2.30 * kWindow;

constexpr int kPlaces = 200;  // at which integrals of windows are evaluated

// Over a block of bins, a node moves by at most this part of a grid step. The polynomials of its
// weights are then exact to 1e-10.
constexpr double kFurthestMove = 0.06;

int bins_at_once(const ArrayPlan& plan, int grid) {
  const Sonar& sonar = plan.setup.sonar;
  const double u = std::min(1.0, 0.1 + std::sin(furthest_beam_rad(sonar)));
  const double move = grid * sonar.array->spacing_m * u * sonar.bandwidth_hz / plan.bins() /
                      plan.setup.water.sound_speed_m_s;
  return std::clamp(static_cast<int>(kFurthestMove / move), 1, kSteerBins);
}

std::vector<SteerBlock> blocks_of(int bins, int block_bins) {
  std::vector<SteerBlock> blocks;
  for (const int side : {0, bins / 2}) {
    for (int k = 0; k < bins / 2; k += block_bins) {
      blocks.push_back({side + k, std::min(block_bins, bins / 2 - k)});
    }
  }
  return blocks;
}

// The place of a node on the grid at the middle of a block, and how far it moves until the block's
// end.
struct NodePlace {
  double middle, reach;
};

NodePlace place_of(const ArrayPlan& plan, const ArrayNodes& nodes, int node,
                   const SteerBlock& block) {
  const Sonar& sonar = plan.setup.sonar;
  const int bins = plan.bins();
  const double k = block.first < bins / 2 ? block.first : block.first - bins;
  const double per_hz = nodes.grid * sonar.array->spacing_m * (nodes.first + node) *
                        nodes.spacing_u / plan.setup.water.sound_speed_m_s;
  if (sonar.array->steering == Steering::phase) return {per_hz * sonar.frequency_hz, 0};
  const double bin_hz = sonar.bandwidth_hz / bins;
  return {per_hz * (sonar.frequency_hz + (k + (block.count - 1) / 2.0) * bin_hz),
          per_hz * nodes.block_bins / 2.0 * bin_hz};
}

// Interpolates the window at the Chebyshev nodes of a block by polynomials.
void fill_weights(const NodePlace& place, int base, double* weight) {
  constexpr int kTerms = kSteerDegree + 1;
  for (int tap = 0; tap < kSteerTaps; ++tap, weight += kTerms) {
    double c[kTerms] = {};
    for (int i = 0; i < kTerms; ++i) {
      const double angle = kPi * (i + 0.5) / kTerms;
      const double x = place.middle + place.reach * std::cos(angle);
      const double value = window(kSteerBeta, (base + tap - x) / (kWindow / 2.0));
      for (int k = 0; k < kTerms; ++k) {
        c[k] += value * std::cos(k * angle) * (k == 0 ? 1.0 : 2.0) / kTerms;
      }
    }
    weight[0] = 8 * c[4];
    weight[1] = 4 * c[3];
    weight[2] = 2 * c[2] - 8 * c[4];
    weight[3] = c[1] - 3 * c[3];
    weight[4] = c[0] - c[2] + c[4];
  }
}

// The element's weight, divided by the transforms of both windows. The width of the nodes' window
// changes with the frequency, as the array in wavelengths does.
void add_element_weight(const ArrayPlan& plan, const WindowIntegral& transform, int element,
                        double turn, ArrayNodes& nodes) {
  const Sonar& sonar = plan.setup.sonar;
  const bool delayed = sonar.array->steering == Steering::true_delay;
  const double band = delayed ? 0.5 * sonar.bandwidth_hz / sonar.frequency_hz : 0;
  const double turns = plan.geometry.y_m[element] * nodes.spacing_u * sonar.frequency_hz /
                       plan.setup.water.sound_speed_m_s;
  const double steer = transform([&](double z) { return kPi * kWindow * z * turn; });
  double c[4] = {};
  for (int i = 0; i < 4; ++i) {
    const double angle = kPi * (i + 0.5) / 4;
    const double value =
        plan.geometry.weight[element] / (steer * node_taper(turns * (1 + band * std::cos(angle))));
    for (int k = 0; k < 4; ++k) c[k] += value * std::cos(k * angle) * (k == 0 ? 1.0 : 2.0) / 4;
  }
  for (const double w : {4 * c[3], 2 * c[2], c[1] - 3 * c[3], c[0] - c[2]}) {
    nodes.element_weight.push_back(w);
  }
}

void fill_transform(const ArrayPlan& plan, ArrayNodes& nodes) {
  const int elements = plan.elements();
  const std::size_t blocks = nodes.blocks.size();
  const double middle = (elements - 1) / 2.0;
  const WindowIntegral transform(kSteerBeta, kWindow, kPlaces);
  for (int n = 0; n < elements; ++n) {
    add_element_weight(plan, transform, n, (n - middle) / nodes.grid, nodes);
  }
  int lowest = 1 << 30, highest = -lowest;
  for (int q = 0; q < nodes.count; ++q) {
    for (std::size_t b = 0; b < blocks; ++b) {
      const NodePlace place = place_of(plan, nodes, q, nodes.blocks[b]);
      const int base = static_cast<int>(std::ceil(place.middle - kSteerTaps / 2.0));
      fill_weights(place, base,
                   nodes.weight.data() + (q * blocks + b) * kSteerTaps * (kSteerDegree + 1));
      nodes.base.push_back(base);
      lowest = std::min(lowest, base);
      highest = std::max(highest, base + kSteerTaps);
    }
  }
  for (std::int32_t& base : nodes.base) base -= lowest;
  nodes.first_row = lowest;
  nodes.rows = highest - lowest;
  // Elements count from the array's middle, which may lie between two of them.
  const double off = elements / 2 - middle;
  for (int g = lowest; g < highest; ++g) {
    nodes.row_phase.push_back(std::polar(1.0, -2 * kPi * off * g / nodes.grid));
  }
}

void fill_orders(const ArrayPlan& plan, ArrayNodes& nodes) {
  const int bins = plan.bins();
  nodes.order_factor.resize(std::size_t(nodes.orders) * bins);
  for (int bin = 0; bin < bins; ++bin) {
    const double k = bin < bins / 2 ? bin : bin - bins;
    const double angle = std::acos(2 * k / bins);
    for (int order = 0; order < nodes.orders; ++order) {
      nodes.order_factor[std::size_t(order) * bins + bin] = std::cos(order * angle);
    }
  }
}

constexpr int kCacheBlock = 64;  // samples; those of all nodes fit into a core's cache
constexpr int kBeamsAtOnce = 64;

std::int64_t plane_stride(const ArrayPlan& plan) { return (plan.samples() + 63) / 64 * 64 + 64; }

// Computes the spectra of all nodes at the bins of one block.
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

double node_taper(double x) {
  constexpr int kWidth = 10;
  const double beta = kPi * kWidth * (1 - 0.5 / kNodeOversampling);
  const WindowIntegral transform(beta, kWidth, kPlaces);
  return transform([x](double z) { return kPi * kWidth * z * x; }) /
         transform([](double) { return 0.0; });
}

std::shared_ptr<const ArrayNodes> make_array_nodes(const ArrayPlan& plan) {
  const int elements = plan.elements();
  if (elements < kFewestElements) return nullptr;
  const int grid = smooth_even_length(2 * elements);
  ArrayNodes nodes(grid, bins_at_once(plan, grid));
  const Sonar& sonar = plan.setup.sonar;
  const double wavelength_m = plan.setup.water.sound_speed_m_s / sonar.frequency_hz;
  nodes.spacing_u = wavelength_m / (kNodeOversampling * elements * sonar.array->spacing_m);
  choose_stretches(plan, nodes);
  if (nodes.stretches.empty()) return nullptr;
  nodes.first = 1 << 30;
  int last = -nodes.first;
  for (const NodeStretch& s : nodes.stretches) {
    for (const int first : s.first) {
      nodes.first = std::min(nodes.first, first);
      last = std::max(last, first + s.taps);
    }
  }
  nodes.count = last - nodes.first;
  for (NodeStretch& s : nodes.stretches) {
    for (int& first : s.first) first -= nodes.first;
  }
  nodes.blocks = blocks_of(plan.bins(), nodes.block_bins);
  nodes.weight =
      AlignedBuffer<double>(nodes.count * nodes.blocks.size() * kSteerTaps * (kSteerDegree + 1));
  fill_transform(plan, nodes);
  fill_orders(plan, nodes);
  return std::make_shared<const ArrayNodes>(std::move(nodes));
}

std::uint64_t node_table_bytes(const ArrayNodes& nodes) {
  std::uint64_t bytes = nodes.weight.size() * sizeof(double) +
                        nodes.base.size() * sizeof(std::int32_t) +
                        nodes.order_factor.size() * sizeof(double);
  for (const NodeStretch& s : nodes.stretches) bytes += s.coefficient.size() * sizeof(float);
  return bytes;
}

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
