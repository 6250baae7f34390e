// The expected power of an array's beams on a device, without that of the means.
#pragma once

#include "synthesis/cpu/fft.h"
#include "synthesis/cuda/array_power_kernels.h"
#include "synthesis/cuda/array_tables.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// What the batch's series have on the device already.
struct ArrayOnDevice {
  const EchoRecord* echoes;
  const float* energy;
  const double *y_m, *beam_cosine;
  const Complex32* means;  // of beams; null: none
};

template <class Queue>
class ArrayPowerProgram {
 public:
  ArrayPowerProgram(Queue& queue, const SynthesisSetup& setup)
      : queue_(queue), setup_(setup), tables_(make_array_power_tables(setup)) {
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
               FilterDirections{grid_.data(), filter_.data(), rows(), tables_.row_filters,
                                kernel_.points, bins(), record_.data()});
    queue_.transform(record_.data(), bins(), rows(), pings, FftDirection::backward);
    for (const PatternBlock& block : tables_.blocks) mix(block, pings, array);
  }

  const float* powers() const { return powers_.data(); }

  // Those of a batch.
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
  double points_per_sample() const { return static_cast<double>(kernel_.points) / bins(); }

  void gather(const PingBatch& batch, const ArrayOnDevice& array) {
    const std::int64_t points = std::int64_t(batch.pings.size()) * rows() * kernel_.points;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    const PlacedEchoes placed{value_.data(), place_.data(), first_.data()};
    queue_.run(
        batch.directed.size(),
        PlaceDirections{array.echoes, directed_.data(), source_pa_m,
                        setup_.sonar.bandwidth_hz * points_per_sample(), kernel_.width, placed});
    queue_.run(points, GatherDirections{placed, directed_.data(), offset_.data(),
                                        cell_weight_.data(), kernel_, nodes(), grid_.data()});
    if (batch.energy.empty()) return;
    queue_.run(points, GatherDirectionCells{array.energy, sectors_.data(), row_offset_.data(),
                                            kernel_, source_pa_m, points_per_sample(), rows(),
                                            beams(), samples(), grid_.data()});
  }

  // Samples of one block, with the patterns of its middle.
  void mix(const PatternBlock& block, std::int64_t pings, const ArrayOnDevice& array) {
    const double range_m = sample_range_m(setup_.sonar, setup_.water, 1) * block.middle();
    const double turns_per_m = setup_.sonar.frequency_hz / setup_.water.sound_speed_m_s;
    const bool plane = setup_.sonar.array->focus == Focus::none;
    const int count = block.end - block.begin;
    beam_waves_.need(std::size_t(beams()) * elements());
    node_waves_.need(std::size_t(nodes()) * elements());
    pattern_.need(std::size_t(beams()) * nodes());
    queue_.run(std::int64_t{beams()} * elements(),
               TurnWavefronts{array.beam_cosine, array.y_m, received_.data(), range_m, turns_per_m,
                              elements(), plane, beam_waves_.data()});
    queue_.run(std::int64_t{nodes()} * elements(),
               TurnWavefronts{node_cosine_.data(), array.y_m, nullptr, range_m, -turns_per_m,
                              elements(), false, node_waves_.data()});
    queue_.run(std::int64_t{beams()} * nodes(),
               MakePatterns{beam_waves_.data(), node_waves_.data(), heard_.data(), nodes(),
                            elements(), pattern_.data()});
    queue_.run(pings * beams() * count,
               MixDirections{record_.data(), array.means, pattern_.data(), beams(), nodes(),
                             samples(), bins(), block.begin, count, powers_.data()});
  }

  Queue& queue_;
  SynthesisSetup setup_;
  ArrayPowerTables tables_;
  DeviceKernel kernel_{};
  DeviceBuffer<float, Queue> coefficient_{queue_}, cell_weight_{queue_}, heard_{queue_},
      pattern_{queue_}, place_{queue_}, powers_{queue_};
  DeviceBuffer<double, Queue> node_cosine_{queue_};
  DeviceBuffer<Complex32, Queue> filter_{queue_}, received_{queue_}, value_{queue_}, grid_{queue_},
      record_{queue_}, beam_waves_{queue_}, node_waves_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
  DeviceBuffer<std::uint32_t, Queue> row_offset_{queue_}, offset_{queue_};
  DeviceBuffer<SectorRecord, Queue> sectors_{queue_};
  DeviceBuffer<DirectionRecord, Queue> directed_{queue_};
};

}  // namespace ensonify
