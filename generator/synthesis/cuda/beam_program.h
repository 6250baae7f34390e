// Beams from ideal beam cells on a device: deposit on time grids, transform, filter, inverse
// transform, and mixing by full sums. The same class template is used for CUDA and for the host
// queue of the tests.
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
        series_(queue, tables_.series),
        power_(queue, tables_.power),
        doppler_(queue, setup) {
    weight_.put(tables_.weight);
    power_weight_.put(tables_.power_weight);
    scale_.put(tables_.scale);
    power_scale_.put(tables_.power_scale);
    queue_.wait();
  }

  // The device memory of a ping with `echoes` scatterers.
  std::uint64_t ping_bytes(std::uint64_t echoes, bool has_volumes) const {
    const std::uint64_t sectors = setup_.sonar.beam_count, bins = setup_.record.transform;
    const std::uint64_t points =
        std::max<std::uint64_t>({std::uint64_t(tables_.series.points),
                                 std::uint64_t(tables_.power.points), doppler_.points()});
    const std::uint64_t shift = doppler_.points() > 0 ? doppler_.echo_bytes() : 0;
    const std::uint64_t volumes = has_volumes ? bins + setup_.record.samples / 2 : 0;
    const std::uint64_t out = 5 * std::uint64_t(setup_.record.samples) / 2;
    return sectors * (points + bins + volumes + out) * sizeof(Complex32) +
           echoes * (sizeof(EchoRecord) + sizeof(Complex32) + 3 * sizeof(float) + shift);
  }

  // Call upload() first, then compute(). The results series() and powers() stay on the device.
  void upload(const PingBatch& batch, const Workers& workers) {
    upload(batch);
    doppler_.upload(batch, workers);
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
    for (auto* b : {&value_, &grid_, &record_, &cells_, &beams_, &means_}) b->drop();
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
  // A DeviceSpread in device memory.
  struct Spread {
    Spread(Queue& queue, const DeviceSpread& spread)
        : coefficient(queue), filter(queue), upper_filter(queue), cell_filter(queue) {
      coefficient.put(spread.coefficient);
      filter.put(spread.filter);
      upper_filter.put(spread.upper_filter);
      cell_filter.put(spread.cell_filter);
      kernel = {coefficient.data(), spread.width, spread.degree, spread.points};
    }
    DeviceBuffer<float, Queue> coefficient;
    DeviceBuffer<Complex32, Queue> filter, upper_filter, cell_filter;
    DeviceKernel kernel{};
  };

  int sectors() const { return setup_.sonar.beam_count; }
  int bins() const { return setup_.record.transform; }
  int samples() const { return setup_.record.samples; }
  double points_per_s(const Spread& spread) const {
    return setup_.sonar.bandwidth_hz * spread.kernel.points / bins();
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
    const std::int64_t pings = batch.pings.size(), rows = pings * sectors();
    const DeviceKernel& kernel = series_.kernel;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    grid_.need(rows * kernel.points);
    record_.need(rows * bins());
    out.need(rows * samples());
    queue_.run(
        batch.echoes.size(),
        PlaceEchoes{echoes_.data(), ping_of_.data(), pings_.data(), setup_.sonar.frequency_hz,
                    source_pa_m, points_per_s(series_), kernel.width, means_only, placed()});
    doppler_.place(echoes_.data(), value_.data());
    queue_.run(rows * kernel.points, GatherSeries{placed(), pings_.data(), offset_.data(), kernel,
                                                  sectors(), grid_.data()});
    queue_.transform(grid_.data(), kernel.points, sectors(), pings, FftDirection::forward);
    const bool has_cells = !means_only && !batch.energy.empty();
    if (has_cells) {
      cells_.need(rows * bins());
      queue_.run(rows * bins(),
                 DrawVolumes{energy_.data(), pings_.data(), volume_key_.data(), source_pa_m,
                             sectors(), samples(), bins(), cells_.data()});
      queue_.transform(cells_.data(), bins(), sectors(), pings, FftDirection::forward);
    }
    queue_.run(rows * bins(), FilterSeries{grid_.data(), has_cells ? cells_.data() : nullptr,
                                           series_.filter.data(), series_.cell_filter.data(),
                                           kernel.points, bins(), record_.data()});
    doppler_.add(pings_.data(), pings, grid_, record_.data());
    queue_.transform(record_.data(), bins(), sectors(), pings, FftDirection::backward);
    const auto mix = [&](auto weights) {
      queue_.run(mixed(pings), MixSeries<decltype(weights)>{record_.data(), pings_.data(), weights,
                                                            scale_.data(), sectors(), samples(),
                                                            bins(), adds_noise, out.data()});
    };
    with_weights(weight_, mix);
  }

  void make_powers(const PingBatch& batch) {
    const int row_pairs = (sectors() + 1) / 2;
    const std::int64_t pings = batch.pings.size(), rows = pings * row_pairs;
    const DeviceKernel& kernel = power_.kernel;
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    grid_.need(rows * kernel.points);
    record_.need(rows * bins());
    powers_.need(pings * sectors() * samples());
    queue_.run(batch.echoes.size(), PlacePowers{echoes_.data(), nullptr, source_pa_m,
                                                points_per_s(power_), kernel.width, placed()});
    queue_.run(rows * kernel.points, GatherPowers{placed(), pings_.data(), offset_.data(), kernel,
                                                  sectors(), grid_.data()});
    queue_.transform(grid_.data(), kernel.points, row_pairs, pings, FftDirection::forward);
    const bool has_cells = !batch.energy.empty();
    if (has_cells) {
      cells_.need(rows * bins());
      queue_.run(rows * bins(), VolumePowers{energy_.data(), source_pa_m, sectors(), samples(),
                                             bins(), cells_.data()});
      queue_.transform(cells_.data(), bins(), row_pairs, pings, FftDirection::forward);
    }
    queue_.run(rows * bins(),
               FilterPowers{grid_.data(), has_cells ? cells_.data() : nullptr, power_.filter.data(),
                            power_.upper_filter.data(), power_.cell_filter.data(), row_pairs, 1, 0,
                            kernel.points, bins(), record_.data()});
    queue_.transform(record_.data(), bins(), row_pairs, pings, FftDirection::backward);
    const auto mix = [&](auto weights) {
      queue_.run(mixed(pings),
                 MixPowers<decltype(weights)>{
                     record_.data(), batch.has_means ? means_.data() : nullptr, weights,
                     power_scale_.data(), sectors(), samples(), bins(), powers_.data()});
    };
    with_weights(power_weight_, mix);
  }

  template <class Mix>
  void with_weights(const DeviceBuffer<float, Queue>& weight, const Mix& mix) const {
    if (tables_.columns == 0) return mix(BandOfWeights{weight.data() + kBeamsAThread, sectors()});
    mix(MatrixOfWeights{weight.data(), tables_.columns});
  }

  std::int64_t mixed(std::int64_t pings) const {
    return pings * ((sectors() + kBeamsAThread - 1) / kBeamsAThread) * samples();
  }

  Queue& queue_;
  SynthesisSetup setup_;
  BeamTables tables_;
  Spread series_, power_;
  DopplerProgram<Queue> doppler_;
  DeviceBuffer<float, Queue> weight_{queue_}, power_weight_{queue_}, scale_{queue_},
      power_scale_{queue_};
  DeviceBuffer<EchoRecord, Queue> echoes_{queue_};
  DeviceBuffer<std::uint32_t, Queue> ping_of_{queue_}, offset_{queue_};
  DeviceBuffer<BatchPing, Queue> pings_{queue_};
  DeviceBuffer<std::uint64_t, Queue> volume_key_{queue_};
  DeviceBuffer<float, Queue> energy_{queue_}, place_{queue_}, powers_{queue_};
  DeviceBuffer<Complex32, Queue> value_{queue_}, grid_{queue_}, record_{queue_}, cells_{queue_},
      beams_{queue_}, means_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
};

}  // namespace ensonify
