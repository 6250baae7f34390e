// The expected power of an array's beams on a device, without the power of the means. Echoes are
// distributed to nodes in u, the cosine of arrival. Beams add up nodes by their power patterns at
// the range of a block of samples. synthesis/cpu/array_power.h describes the approximation.
//
//   GatherDirections       echoes -> a point of two nodes' grid; GatherDirectionCells adds volumes
//   TurnWavefronts         phases of waves at elements, and weights of elements in beams
//   MakePatterns           power patterns of beams at nodes
//   ArrayPowerProgram      all of these, and MixPowers from nodes to beams
#pragma once

#include "synthesis/cuda/array_kernels.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/node_kernels.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

constexpr int kDirectionTaps = 4;

// Writes grid [pings][nodes / 2][points]. re is an even node, im is the odd node after it.
struct GatherDirections {
  PlacedEchoes placed;
  const DirectionRecord* directed;
  const std::uint32_t* offset;  // [pings][groups + 1]; a group shares the first of four nodes
  const float* cell_weight;     // [cells][kDirectionTaps]
  DeviceKernel kernel;
  int nodes;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const int rows = nodes / 2, groups = nodes - kDirectionTaps + 1;
    const auto node = static_cast<int>(i / kernel.points % rows) * 2;
    const std::uint32_t* at = offset + i / kernel.points / rows * (groups + 1);
    const int low = node - kDirectionTaps + 1;
    Complex32 sum{0, 0};
    for (int g = low > 0 ? low : 0; g <= node + 1 && g < groups; ++g) {
      for (int turn = -1; turn <= 1; ++turn) {
        const std::int32_t p = point + turn * kernel.points;
        if (p < -kernel.width || p >= kernel.points + kernel.width) continue;
        add(at[g], at[g + 1], p, node - g, sum);
      }
    }
    grid[i] = sum;
  }

  // `tap` is the number of the even node among the nodes that echoes [begin, end) reach.
  ENSONIFY_HD void add(std::uint32_t begin, std::uint32_t end, std::int32_t point, int tap,
                       Complex32& sum) const {
    for (std::uint32_t low = first_reaching(placed, kernel, begin, end, point);
         low < end && placed.first[low] <= point; ++low) {
      const float w = kernel_at(kernel, point - placed.first[low], placed.offset[low]);
      const float power = w * placed.value[low].re;
      const float* of_cell = cell_weight + directed[low].cell * kDirectionTaps;
      if (tap >= 0 && tap < kDirectionTaps) sum.re += power * of_cell[tap];
      if (tap + 1 < kDirectionTaps) sum.im += power * of_cell[tap + 1];
    }
  }
};

// Adds volumes to the same grid, from energy [pings][beams][samples] at whole samples.
struct GatherDirectionCells {
  const float* energy;
  const SectorRecord* sectors;
  const std::uint32_t* row_offset;  // [rows + 1], among these
  DeviceKernel kernel;
  double source_pa_m, points_per_sample;
  int rows, beams, samples;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const auto row = static_cast<int>(i / kernel.points % rows);
    const float* of_ping = energy + i / kernel.points / rows * beams * samples;
    const double half = 0.5 * kernel.width;
    Complex32 sum{0, 0};
    for (int turn = -1; turn <= 1; ++turn) {
      const std::int32_t p = point + turn * kernel.points;
      const double low = std::floor((p - half) / points_per_sample);
      const double high = std::ceil((p + half) / points_per_sample);
      const int last = high < samples - 1 ? static_cast<int>(high) : samples - 1;
      for (int n = low > 0 ? static_cast<int>(low) : 0; n <= last; ++n) {
        float offset;
        std::int32_t first;
        place_echo(n, points_per_sample, kernel.width, offset, first);
        if (p < first || p >= first + kernel.width) continue;
        add(of_ping + n, row, kernel_at(kernel, p - first, offset), sum);
      }
    }
    const auto power = static_cast<float>(source_pa_m * source_pa_m);
    grid[i] += power * sum;
  }

  ENSONIFY_HD void add(const float* of_sample, int row, float w, Complex32& sum) const {
    for (std::uint32_t s = row_offset[row]; s < row_offset[row + 1]; ++s) {
      const float e = w * of_sample[std::int64_t{sectors[s].sector} * samples];
      sum.re += e * sectors[s].even;
      sum.im += e * sectors[s].odd;
    }
  }
};

// Writes out [elements][rows]: the phasor at every element of a wave that is plane or comes from
// `range_m`. Rows behind the waves are zero.
struct TurnWavefronts {
  const double* cosine;  // [waves]
  const double* y_m;
  const Complex32* factor;  // [elements], or null: 1
  double range_m, turns_per_m;
  int waves, rows;
  bool plane;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t wave = i % rows, n = i / rows;
    out[i] = {0, 0};
    if (wave >= waves) return;
    const double u = cosine[wave];
    const double later_m = plane ? -y_m[n] * u : longer_way_m(range_m, range_m * u, y_m[n]);
    out[i] = turned(factor != nullptr ? factor[n] : Complex32{1, 0}, later_m * turns_per_m);
  }
};

// Writes pattern [blocks of beams][nodes] for MixPowers.
struct MakePatterns {
  const Complex32 *beams, *waves;  // from TurnWavefronts, for all beams of the blocks and for nodes
  const float* heard;              // [nodes], power pattern of one element
  int blocks, nodes, elements;
  BeamWeights* pattern;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t node = i % nodes;
    const Complex32* b = beams + i / nodes * kBeamsAThread;
    const Complex32* w = waves + node;
    Complex32 sum[kBeamsAThread] = {};
    for (int n = 0; n < elements; ++n, b += blocks * kBeamsAThread, w += nodes) {
      const Complex32 z = *w;
      ENSONIFY_UNROLL
      for (int j = 0; j < kBeamsAThread; ++j) sum[j] += product(b[j], z);
    }
    BeamWeights weights;
    ENSONIFY_UNROLL
    for (int j = 0; j < kBeamsAThread; ++j) {
      weights.of_beam[j] = heard[node] * (sum[j].re * sum[j].re + sum[j].im * sum[j].im);
    }
    pattern[i] = weights;
  }
};

// Arrays of the batch that the series have already put on the device.
struct ArrayOnDevice {
  const EchoRecord* echoes;
  const float* energy;
  const double *y_m, *beam_cosine;
  const Complex32* means;  // of beams; null if there are none
};

// The patterns of all blocks of samples are kept on the device if they take at most this, and made
// for every batch otherwise.
inline constexpr std::uint64_t kKeptPatternBytes = std::uint64_t{256} << 20;

template <class Queue>
class ArrayPowerProgram {
 public:
  ArrayPowerProgram(Queue& queue, const SynthesisSetup& setup,
                    std::uint64_t kept_bytes = kKeptPatternBytes)
      : queue_(queue),
        setup_(setup),
        tables_(make_array_power_tables(setup)),
        kept_bytes_(kept_bytes) {
    coefficient_.put(tables_.power.coefficient);
    filter_.put(tables_.filter);
    cell_weight_.put(tables_.cell_weight);
    node_cosine_.put(tables_.node_cosine);
    heard_.put(tables_.node_heard);
    received_.put(tables_.received);
    sectors_.put(tables_.sectors);
    row_offset_.put(tables_.row_offset);
    const DeviceSpread& power = tables_.power;
    kernel_ = {coefficient_.data(), power.width, power.degree, power.points};
    queue_.wait();
  }

  std::uint64_t ping_bytes(std::uint64_t echoes) const {
    return std::uint64_t(rows()) * (kernel_.points + bins()) * sizeof(Complex32) +
           std::uint64_t(beams()) * samples() * sizeof(float) +
           echoes * (sizeof(DirectionRecord) + sizeof(Complex32) + 2 * sizeof(float));
  }

  void run(const PingBatch& batch, const ArrayOnDevice& array) {
    const std::int64_t pings = batch.pings.size(), all_rows = pings * rows();
    const std::size_t echoes = batch.directed.size();
    directed_.put(batch.directed);
    offset_.put(batch.direction_offset);
    value_.need(echoes);
    place_.need(echoes);
    first_.need(echoes);
    grid_.need(all_rows * kernel_.points);
    record_.need(all_rows * bins());
    powers_.need(pings * beams() * samples());
    gather(batch, array);
    queue_.transform(grid_.data(), kernel_.points, rows(), pings, FftDirection::forward);
    queue_.run(all_rows * bins(),
               FilterPowers{grid_.data(), nullptr, filter_.data(), filter_.data() + bins(), nullptr,
                            rows(), tables_.row_filters, 2 * bins(), kernel_.points, bins(),
                            record_.data()});
    queue_.transform(record_.data(), bins(), rows(), pings, FftDirection::backward);
    for (std::size_t number = 0; number < tables_.blocks.size(); ++number) {
      const PatternBlock& block = tables_.blocks[number];
      const int count = block.end - block.begin;
      const BeamWeights* pattern = pattern_of(number, array);
      queue_.run(pings * beam_blocks() * count,
                 MixPowers{record_.data(), array.means, pattern, nodes(), beams(), samples(),
                           bins(), block.begin, count, powers_.data()});
    }
  }

  const float* powers() const { return powers_.data(); }

  // Releases the buffers of batches.
  void drop_buffers() {
    for (auto* b : {&value_, &grid_, &record_}) b->drop();
    for (auto* b : {&place_, &powers_}) b->drop();
    first_.drop();
    offset_.drop();
    directed_.drop();
  }

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int bins() const { return setup_.record.transform; }
  int samples() const { return setup_.record.samples; }
  int elements() const { return setup_.sonar.array->elements; }
  int nodes() const { return tables_.grid.nodes; }
  int rows() const { return nodes() / 2; }
  int beam_blocks() const { return (beams() + kBeamsAThread - 1) / kBeamsAThread; }
  double points_per_sample() const { return static_cast<double>(kernel_.points) / bins(); }

  void gather(const PingBatch& batch, const ArrayOnDevice& array) {
    const std::int64_t points = std::int64_t(batch.pings.size()) * rows() * kernel_.points;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    const PlacedEchoes placed{value_.data(), place_.data(), first_.data()};
    queue_.run(batch.directed.size(),
               PlacePowers{array.echoes, directed_.data(), source_pa_m,
                           setup_.sonar.bandwidth_hz * points_per_sample(), kernel_.width, placed});
    queue_.run(points, GatherDirections{placed, directed_.data(), offset_.data(),
                                        cell_weight_.data(), kernel_, nodes(), grid_.data()});
    if (batch.energy.empty()) return;
    queue_.run(points, GatherDirectionCells{array.energy, sectors_.data(), row_offset_.data(),
                                            kernel_, source_pa_m, points_per_sample(), rows(),
                                            beams(), samples(), grid_.data()});
  }

  // The patterns of the middle of a block. Blocks are asked for in their order.
  const BeamWeights* pattern_of(std::size_t number, const ArrayOnDevice& array) {
    const std::size_t size = std::size_t(beam_blocks()) * nodes(), count = tables_.blocks.size();
    const bool keeps = count * size * sizeof(BeamWeights) <= kept_bytes_;
    pattern_.need(keeps ? count * size : size);
    BeamWeights* pattern = pattern_.data() + (keeps ? number * size : 0);
    if (keeps && number < made_) return pattern;
    make_patterns(tables_.blocks[number], array, pattern);
    made_ = number + 1;
    return pattern;
  }

  void make_patterns(const PatternBlock& block, const ArrayOnDevice& array, BeamWeights* pattern) {
    const double range_m = sample_range_m(setup_.sonar, setup_.water, 1) * block.middle();
    const double turns_per_m = setup_.sonar.frequency_hz / setup_.water.sound_speed_m_s;
    const bool plane = setup_.sonar.array->focus == Focus::none;
    const int rows = beam_blocks() * kBeamsAThread;
    beam_waves_.need(std::size_t(rows) * elements());
    node_waves_.need(std::size_t(nodes()) * elements());
    queue_.run(std::int64_t{rows} * elements(),
               TurnWavefronts{array.beam_cosine, array.y_m, received_.data(), range_m, turns_per_m,
                              beams(), rows, plane, beam_waves_.data()});
    queue_.run(std::int64_t{nodes()} * elements(),
               TurnWavefronts{node_cosine_.data(), array.y_m, nullptr, range_m, -turns_per_m,
                              nodes(), nodes(), false, node_waves_.data()});
    queue_.run(std::int64_t{beam_blocks()} * nodes(),
               MakePatterns{beam_waves_.data(), node_waves_.data(), heard_.data(), beam_blocks(),
                            nodes(), elements(), pattern});
  }

  Queue& queue_;
  SynthesisSetup setup_;
  ArrayPowerTables tables_;
  std::uint64_t kept_bytes_;  // of patterns, at most
  DeviceKernel kernel_{};
  DeviceBuffer<float, Queue> coefficient_{queue_}, cell_weight_{queue_}, heard_{queue_},
      place_{queue_}, powers_{queue_};
  DeviceBuffer<double, Queue> node_cosine_{queue_};
  DeviceBuffer<BeamWeights, Queue> pattern_{queue_};
  std::size_t made_ = 0;  // blocks whose patterns are kept
  DeviceBuffer<Complex32, Queue> filter_{queue_}, received_{queue_}, value_{queue_}, grid_{queue_},
      record_{queue_}, beam_waves_{queue_}, node_waves_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
  DeviceBuffer<std::uint32_t, Queue> row_offset_{queue_}, offset_{queue_};
  DeviceBuffer<SectorRecord, Queue> sectors_{queue_};
  DeviceBuffer<DirectionRecord, Queue> directed_{queue_};
};

}  // namespace ensonify
