// Beams from the spectra of an array's elements, as in cpu/array_nodes.h: elements are steered to
// nodes, and beams are short sums of neighboring nodes, with coefficients that focus at each
// sample. Samples that are too near for nodes are sums of all elements.
//
// Functors are as in beam_kernels.h.
//
//   SpreadElements  elements -> rows of a transform along the array
//   SteerNodes      rows of the transform -> spectra of nodes, for each order
//   SumNodes        records of nodes -> beams
//   ArrayBeams      all of these
#pragma once

#include <algorithm>
#include <cstdint>

#include "synthesis/cuda/array_kernels.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

// The frequency of a bin, from the carrier, as a part of half the band.
ENSONIFY_HD inline float part_of_band(int bin, int transform) {
  return 2 * static_cast<float>(bin < transform / 2 ? bin : bin - transform) /
         static_cast<float>(transform);
}

// Writes rows [pings][grid][transform] from spectrum [pings][elements][transform]. The array's
// middle is row 0.
struct SpreadElements {
  const Complex32* spectrum;
  const ElementWeight* weight;  // [elements]
  int elements, grid, transform;
  Complex32* rows;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const auto row = static_cast<int>(i / transform % grid);
    const std::int64_t ping = i / transform / grid;
    const int n = row + elements / 2 < grid ? row + elements / 2 : row + elements / 2 - grid;
    rows[i] = {0, 0};
    if (n >= elements) return;
    const ElementWeight w = weight[n];
    const float x = part_of_band(k, transform);
    rows[i] = (((w.power[0] * x + w.power[1]) * x + w.power[2]) * x + w.power[3]) *
              spectrum[(ping * elements + n) * transform + k];
  }
};

// Writes out [pings][orders][nodes][transform]: the spectrum of each node times the Chebyshev
// polynomials of the frequency. The count is pings times nodes times transform.
struct SteerNodes {
  const Complex32* rows;       // [pings][grid][transform]
  const Complex32* row_phase;  // [reached rows]
  const std::int32_t* base;    // [nodes][blocks], the first reached row of a node
  const float* weight;         // [nodes][blocks][kSteerTaps][kSteerDegree + 1]
  int nodes, orders, blocks, block_bins, grid, first_row, transform;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const std::int64_t node = i / transform % nodes, ping = i / transform / nodes;
    // Blocks of bins are numbered on either side of the carrier.
    const int half = transform / 2, in_side = k % half, number = in_side / block_bins;
    const int begin = number * block_bins;
    const int count = block_bins < half - begin ? block_bins : half - begin;
    const std::int64_t at = node * blocks + (k < half ? 0 : blocks / 2) + number;
    const float t =
        static_cast<float>(2 * (in_side - begin) + 1 - count) / static_cast<float>(block_bins);
    const float* w = weight + at * kSteerTaps * (kSteerDegree + 1);
    const int first = base[at];
    Complex32 sum{0, 0};
    for (int tap = 0; tap < kSteerTaps; ++tap, w += kSteerDegree + 1) {
      int row = first_row + first + tap;
      while (row < 0) row += grid;
      while (row >= grid) row -= grid;
      const Complex32 z = rows[(ping * grid + row) * transform + k];
      const float value = (((w[0] * t + w[1]) * t + w[2]) * t + w[3]) * t + w[4];
      sum += value * product(row_phase[first + tap], z);
    }
    const float x = part_of_band(k, transform);
    float before = x, factor = 1;
    for (int order = 0; order < orders; ++order) {
      out[((ping * orders + order) * nodes + node) * transform + k] = factor * sum;
      const float next = 2 * x * factor - before;
      before = factor;
      factor = next;
    }
  }
};

// Writes the samples of all stretches to beams [pings][beams][samples]. The count is pings times
// pieces times beams times kGridLanes.
struct SumNodes {
  const Complex32* record;  // [pings][orders][nodes][transform]
  const NodePiece* pieces;
  const Complex32* coefficient;  // of all stretches
  const std::int32_t* first;     // [stretches][beams], node of the first tap
  const float* time;             // [samples]
  int piece_count, beams, nodes, orders, samples, transform;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto lane = static_cast<int>(i % kGridLanes);
    const std::int64_t beam = i / kGridLanes % beams;
    const NodePiece piece = pieces[i / kGridLanes / beams % piece_count];
    const std::int64_t ping = i / kGridLanes / beams / piece_count;
    const Complex32* c =
        coefficient + piece.coefficient + beam * piece.orders * piece.taps * (piece.degree + 1);
    const int n = piece.first + lane;
    float x[kSamplesAThread] = {};
    Complex32 sum[kSamplesAThread] = {};
    ENSONIFY_UNROLL
    for (int j = 0; j < kSamplesAThread; ++j) {
      if (j * kGridLanes + lane < piece.count) x[j] = time[n + j * kGridLanes];
    }
    const std::int32_t node = first[piece.stretch * beams + beam];
    for (int order = 0; order < piece.orders; ++order) {
      const Complex32* from = record + ((ping * orders + order) * nodes + node) * transform + n;
      for (int tap = 0; tap < piece.taps; ++tap, from += transform, c += piece.degree + 1) {
        add(piece, c, from, x, lane, sum);
      }
    }
    ENSONIFY_UNROLL
    for (int j = 0; j < kSamplesAThread; ++j) {
      if (j * kGridLanes + lane >= piece.count) continue;
      out[(ping * beams + beam) * samples + n + j * kGridLanes] = sum[j];
    }
  }

  // Adds one node, with the coefficient c at the time x.
  ENSONIFY_HD static void add(const NodePiece& piece, const Complex32* c, const Complex32* from,
                              const float* x, int lane, Complex32* sum) {
    Complex32 w[kSamplesAThread];
    ENSONIFY_UNROLL
    for (int j = 0; j < kSamplesAThread; ++j) w[j] = c[0];
    for (int d = 1; d <= piece.degree; ++d) {
      const Complex32 next = c[d];
      ENSONIFY_UNROLL
      for (int j = 0; j < kSamplesAThread; ++j) {
        w[j] = {w[j].re * x[j] + next.re, w[j].im * x[j] + next.im};
      }
    }
    ENSONIFY_UNROLL
    for (int j = 0; j < kSamplesAThread; ++j) {
      if (j * kGridLanes + lane < piece.count) sum[j] += product(w[j], from[j * kGridLanes]);
    }
  }
};

template <class Queue>
class ArrayBeams {
 public:
  ArrayBeams(Queue& queue, const SynthesisSetup& setup, const ArrayTables& tables)
      : queue_(queue), setup_(setup), nodes_(tables.nodes) {
    y_m_.put(tables.y_m);
    weight_.put(tables.weight);
    beam_cosine_.put(tables.beam_cosine);
    steering_.put(tables.steering);
    correction_.put(tables.correction);
    begin_.put(tables.begin);
    tap_.put(tables.tap);
    element_weight_.put(nodes_.element_weight);
    row_phase_.put(nodes_.row_phase);
    base_.put(nodes_.base);
    steer_weight_.put(nodes_.steer_weight);
    pieces_.put(nodes_.pieces);
    coefficient_.put(nodes_.coefficient);
    first_.put(nodes_.first);
    time_.put(nodes_.time);
  }

  // Device memory for each ping, with the part of the rows that `grid_size` points do not hold.
  std::uint64_t ping_bytes(std::uint64_t grid_size) const {
    const std::uint64_t rows = std::uint64_t(nodes_.grid) * bins();
    const std::uint64_t wide = near() > 0 ? std::uint64_t(elements()) * 2 * bins() : 0;
    return sizeof(Complex32) * (wide + std::uint64_t(nodes_.orders) * nodes_.count * bins() +
                                (rows > grid_size ? rows - grid_size : 0));
  }

  // Writes beams [pings][beams][samples] from spectrum [pings][elements][bins]. Overwrites `rows`.
  void form(std::int64_t pings, const Complex32* spectrum, DeviceBuffer<Complex32, Queue>& rows,
            Complex32* out) {
    if (near() > 0) sum_elements(pings, spectrum, out);
    if (nodes_.count == 0) return;
    rows.need(pings * nodes_.grid * bins());
    record_.need(pings * nodes_.orders * nodes_.count * bins());
    queue_.run(pings * nodes_.grid * bins(),
               SpreadElements{spectrum, element_weight_.data(), elements(), nodes_.grid, bins(),
                              rows.data()});
    queue_.transform_columns(rows.data(), nodes_.grid, bins(), pings, FftDirection::forward);
    queue_.run(pings * nodes_.count * bins(),
               SteerNodes{rows.data(), row_phase_.data(), base_.data(), steer_weight_.data(),
                          nodes_.count, nodes_.orders, nodes_.blocks, nodes_.block_bins,
                          nodes_.grid, nodes_.first_row, bins(), record_.data()});
    queue_.transform(record_.data(), bins(), nodes_.orders * nodes_.count, pings,
                     FftDirection::backward);
    const auto pieces = static_cast<int>(nodes_.pieces.size());
    queue_.run(
        pings * pieces * beams() * kGridLanes,
        SumNodes{record_.data(), pieces_.data(), coefficient_.data(), first_.data(), time_.data(),
                 pieces, beams(), nodes_.count, nodes_.orders, samples(), bins(), out});
  }

  const double* y_m() const { return y_m_.data(); }
  const double* beam_cosine() const { return beam_cosine_.data(); }

  // Releases the buffers of batches.
  void drop_buffers() {
    wide_.drop();
    record_.drop();
  }

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int bins() const { return setup_.record.transform; }
  int samples() const { return setup_.record.samples; }
  int elements() const { return setup_.sonar.array->elements; }
  int near() const { return nodes_.near_samples; }

  void sum_elements(std::int64_t pings, const Complex32* spectrum, Complex32* out) {
    const std::int64_t rows = pings * elements();
    const double turns_per_m = setup_.sonar.frequency_hz / setup_.water.sound_speed_m_s;
    wide_.need(rows * 2 * bins());
    queue_.run(rows * 2 * bins(), WidenRecords{spectrum, correction_.data(), bins(), wide_.data()});
    queue_.transform(wide_.data(), 2 * bins(), elements(), pings, FftDirection::backward);
    queue_.run(
        pings * beams() * near(),
        SumElements{wide_.data(), begin_.data(), tap_.data(), steering_.data(), weight_.data(),
                    y_m_.data(), beam_cosine_.data(), sample_range_m(setup_.sonar, setup_.water, 1),
                    turns_per_m, beams(), elements(), near(), samples(), bins(),
                    setup_.sonar.array->focus == Focus::dynamic, out});
  }

  Queue& queue_;
  SynthesisSetup setup_;
  ArrayNodeTables nodes_;
  DeviceBuffer<double, Queue> y_m_{queue_}, beam_cosine_{queue_};
  DeviceBuffer<float, Queue> weight_{queue_}, correction_{queue_}, steer_weight_{queue_},
      time_{queue_};
  DeviceBuffer<ElementTaps, Queue> tap_{queue_};
  DeviceBuffer<ElementWeight, Queue> element_weight_{queue_};
  DeviceBuffer<NodePiece, Queue> pieces_{queue_};
  DeviceBuffer<std::int32_t, Queue> begin_{queue_}, base_{queue_}, first_{queue_};
  DeviceBuffer<Complex32, Queue> steering_{queue_}, row_phase_{queue_}, coefficient_{queue_},
      wide_{queue_}, record_{queue_};
};

}  // namespace ensonify
