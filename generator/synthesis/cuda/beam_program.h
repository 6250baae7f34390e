// Beams from ideal beam cells on a device: deposit on time grids of cells, spreading over the nodes
// of cpu/beam_nodes.h, transform, filter, inverse transform, and beams as sums of nodes. The same
// class template is used for CUDA and for the host queue of the tests.
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <new>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/doppler_echoes.h"
#include "synthesis/cuda/node_kernels.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

template <class Queue>
class BeamProgram {
 public:
  BeamProgram(Queue& queue, const SynthesisSetup& setup)
      : queue_(queue),
        setup_(setup),
        tables_(make_beam_tables(setup)),
        series_(queue, tables_.series, tables_.mixing),
        power_(queue, tables_.power, tables_.power_mixing),
        doppler_(queue, setup) {
    queue_.wait();
  }

  // The device memory of a ping with `echoes` scatterers.
  std::uint64_t ping_bytes(std::uint64_t echoes, bool has_volumes) const {
    const std::uint64_t sectors = setup_.sonar.beam_count, bins = setup_.record.transform;
    const std::uint64_t points =
        std::max<std::uint64_t>({std::uint64_t(tables_.series.points),
                                 std::uint64_t(tables_.power.points), doppler_.points()});
    const std::uint64_t shift = doppler_.points() > 0 ? doppler_.echo_bytes() : 0;
    const std::uint64_t nodes = std::max(series_.nodes, power_.nodes / 2);
    const std::uint64_t volumes =
        has_volumes ? (sectors + nodes) * bins + sectors * setup_.record.samples / 2 : 0;
    const std::uint64_t out = 5 * std::uint64_t(setup_.record.samples) / 2;
    return (sectors * (points + out) + nodes * (points + bins) + volumes) * sizeof(Complex32) +
           echoes * (sizeof(EchoRecord) + sizeof(Complex32) + 3 * sizeof(float) + shift);
  }

  // Call upload() first, then compute(). The results series() and powers() stay on the device.
  void upload(const PingBatch& batch, const Workers& workers) {
    upload(batch);
    doppler_.upload(batch, workers);
  }
  // Like upload(), where only keys and noise of the same pings are new.
  void renew(const PingBatch& batch) {
    pings_.put(batch.pings);
    volume_key_.put(batch.volume_key);
  }
  void compute(const PingBatch& batch) {
    make_series(batch, false, batch.has_noise, beams_);
    if (!batch.wants_clean) return;
    if (batch.has_means) make_series(batch, true, false, means_);
    make_powers(batch);
  }

  Complex32* series() const { return beams_.data(); }
  const float* powers() const { return powers_.data(); }

  // Releases the buffers of batches, results included.
  void drop_buffers() {
    for (auto* b :
         {&value_, &grid_, &node_grid_, &record_, &cells_, &node_cells_, &beams_, &means_})
      b->drop();
    for (auto* b : {&energy_, &place_, &powers_}) b->drop();
    echoes_.drop();
    ping_of_.drop();
    offset_.drop();
    pings_.drop();
    volume_key_.drop();
    first_.drop();
    doppler_.drop_buffers();
  }

 private:
  // A DeviceSpread and a DeviceMixing in device memory.
  struct Tables {
    Tables(Queue& queue, const DeviceSpread& spread, const DeviceMixing& mixing)
        : nodes(mixing.nodes),
          coefficient(queue),
          filter(queue),
          upper_filter(queue),
          cell_filter(queue),
          cells(queue),
          row_offset(queue),
          weight(queue) {
      coefficient.put(spread.coefficient);
      filter.put(spread.filter);
      upper_filter.put(spread.upper_filter);
      cell_filter.put(spread.cell_filter);
      cells.put(mixing.cells);
      row_offset.put(mixing.row_offset);
      weight.put(mixing.weight);
      kernel = {coefficient.data(), spread.width, spread.degree, spread.points};
    }
    NodeReach reach() const { return {cells.data(), row_offset.data(), nodes}; }

    int nodes;
    DeviceBuffer<float, Queue> coefficient;
    DeviceBuffer<Complex32, Queue> filter, upper_filter, cell_filter;
    DeviceBuffer<SectorRecord, Queue> cells;
    DeviceBuffer<std::uint32_t, Queue> row_offset;
    DeviceBuffer<BeamWeights, Queue> weight;
    DeviceKernel kernel{};
  };

  int sectors() const { return setup_.sonar.beam_count; }
  int bins() const { return setup_.record.transform; }
  int samples() const { return setup_.record.samples; }
  double points_per_s(const Tables& tables) const {
    return setup_.sonar.bandwidth_hz * tables.kernel.points / bins();
  }

  void upload(const PingBatch& batch) {
    echoes_.put(batch.echoes);
    ping_of_.put(batch.ping_of);
    offset_.put(batch.offset);
    pings_.put(batch.pings);
    volume_key_.put(batch.volume_key);
    energy_.put(batch.energy);
    value_.need(batch.echoes.size());
    place_.need(batch.echoes.size());
    first_.need(batch.echoes.size());
  }

  PlacedEchoes placed() const { return {value_.data(), place_.data(), first_.data()}; }

  void make_series(const PingBatch& batch, bool means_only, bool adds_noise,
                   DeviceBuffer<Complex32, Queue>& out) {
    const std::int64_t pings = batch.pings.size(), nodes = series_.nodes;
    const DeviceKernel& kernel = series_.kernel;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    grid_.need(pings * sectors() * kernel.points);
    record_.need(pings * nodes * bins());
    out.need(pings * sectors() * samples());
    queue_.run(
        batch.echoes.size(),
        PlaceEchoes{echoes_.data(), ping_of_.data(), pings_.data(), setup_.sonar.frequency_hz,
                    source_pa_m, points_per_s(series_), kernel.width, means_only, placed()});
    doppler_.place(echoes_.data(), value_.data());
    queue_.run(pings * sectors() * kGridLanes, GatherSeries{placed(), pings_.data(), offset_.data(),
                                                            kernel, sectors(), grid_.data()});
    const auto to_nodes = [&](int length) {
      return spread<SpreadSeries>(series_, grid_, nodes, length, pings, node_grid_);
    };
    const Complex32* grids = transformed(to_nodes(kernel.points), kernel.points, nodes, pings);
    const bool has_cells = !means_only && !batch.energy.empty();
    const Complex32* cells = nullptr;
    if (has_cells) {
      cells_.need(pings * sectors() * bins());
      queue_.run(pings * sectors() * bins(),
                 DrawVolumes{energy_.data(), pings_.data(), volume_key_.data(), source_pa_m,
                             sectors(), samples(), bins(), cells_.data()});
      cells = transformed(spread<SpreadSeries>(series_, cells_, nodes, bins(), pings, node_cells_),
                          bins(), nodes, pings);
    }
    queue_.run(pings * nodes * bins(),
               FilterSeries{grids, cells, series_.filter.data(), series_.cell_filter.data(),
                            kernel.points, bins(), record_.data()});
    doppler_.add(pings_.data(), pings, series_.nodes, grid_, to_nodes, record_.data());
    queue_.transform(record_.data(), bins(), series_.nodes, pings, FftDirection::backward);
    queue_.run(mixed(pings),
               MixSeries{record_.data(), pings_.data(), series_.weight.data(), series_.nodes,
                         sectors(), samples(), bins(), adds_noise, out.data()});
  }

  void make_powers(const PingBatch& batch) {
    const int row_pairs = (sectors() + 1) / 2, node_pairs = power_.nodes / 2;
    const std::int64_t pings = batch.pings.size();
    const DeviceKernel& kernel = power_.kernel;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    grid_.need(pings * row_pairs * kernel.points);
    record_.need(pings * node_pairs * bins());
    powers_.need(pings * sectors() * samples());
    queue_.run(batch.echoes.size(), PlacePowers{echoes_.data(), nullptr, source_pa_m,
                                                points_per_s(power_), kernel.width, placed()});
    queue_.run(pings * row_pairs * kGridLanes, GatherPowers{placed(), pings_.data(), offset_.data(),
                                                            kernel, sectors(), grid_.data()});
    const Complex32* grids = transformed(
        spread<SpreadPowers>(power_, grid_, node_pairs, kernel.points, pings, node_grid_),
        kernel.points, node_pairs, pings);
    const Complex32* cells = nullptr;
    if (!batch.energy.empty()) {
      cells_.need(pings * row_pairs * bins());
      queue_.run(pings * row_pairs * bins(), VolumePowers{energy_.data(), source_pa_m, sectors(),
                                                          samples(), bins(), cells_.data()});
      cells =
          transformed(spread<SpreadPowers>(power_, cells_, node_pairs, bins(), pings, node_cells_),
                      bins(), node_pairs, pings);
    }
    queue_.run(pings * node_pairs * bins(),
               FilterPowers{grids, cells, power_.filter.data(), power_.upper_filter.data(),
                            power_.cell_filter.data(), node_pairs, 1, 0, kernel.points, bins(),
                            record_.data()});
    queue_.transform(record_.data(), bins(), node_pairs, pings, FftDirection::backward);
    queue_.run(mixed(pings), MixPowers{record_.data(), batch.has_means ? means_.data() : nullptr,
                                       power_.weight.data(), power_.nodes, sectors(), samples(),
                                       bins(), 0, samples(), powers_.data()});
  }

  // Spreads rows of sectors, [pings][...][length], over `rows` rows of nodes.
  template <class Functor>
  Complex32* spread(const Tables& tables, const DeviceBuffer<Complex32, Queue>& from,
                    std::int64_t rows, int length, std::int64_t pings,
                    DeviceBuffer<Complex32, Queue>& to) {
    to.need(pings * rows * length);
    queue_.run(pings * (tables.nodes / 2) * length,
               Functor{from.data(), tables.reach(), sectors(), length, to.data()});
    return to.data();
  }

  const Complex32* transformed(Complex32* rows, int length, std::int64_t at_once,
                               std::int64_t pings) {
    queue_.transform(rows, length, static_cast<int>(at_once), pings, FftDirection::forward);
    return rows;
  }

  std::int64_t mixed(std::int64_t pings) const {
    return pings * ((sectors() + kBeamsAThread - 1) / kBeamsAThread) * samples();
  }

  Queue& queue_;
  SynthesisSetup setup_;
  BeamTables tables_;
  Tables series_, power_;
  DopplerProgram<Queue> doppler_;
  DeviceBuffer<EchoRecord, Queue> echoes_{queue_};
  DeviceBuffer<std::uint32_t, Queue> ping_of_{queue_}, offset_{queue_};
  DeviceBuffer<BatchPing, Queue> pings_{queue_};
  DeviceBuffer<std::uint64_t, Queue> volume_key_{queue_};
  DeviceBuffer<float, Queue> energy_{queue_}, place_{queue_}, powers_{queue_};
  DeviceBuffer<Complex32, Queue> value_{queue_}, grid_{queue_}, node_grid_{queue_}, record_{queue_},
      cells_{queue_}, node_cells_{queue_}, beams_{queue_}, means_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
};

}  // namespace ensonify
