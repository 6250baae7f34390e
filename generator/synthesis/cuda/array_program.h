// A receiving line array on a device, as defined in synthesis/beamforming.h. Echoes at the origin
// are placed on every element's time grid, transformed and filtered. Beams add up the elements'
// records. The same class template is used for CUDA and for the host queue of the tests.
#pragma once

#include <algorithm>
#include <new>

#include "synthesis/cuda/array_beams.h"
#include "synthesis/cuda/array_kernels.h"
#include "synthesis/cuda/array_power_program.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/doppler_echoes.h"
#include "synthesis/cuda/element_grids.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

template <class Queue>
class ArrayProgram {
 public:
  ArrayProgram(Queue& queue, const SynthesisSetup& setup)
      : queue_(queue),
        setup_(setup),
        tables_(make_array_tables(setup)),
        power_(queue, setup),
        shifted_(queue, setup),
        grids_(queue, setup),
        array_beams_(queue, setup, tables_) {
    point_weight_.put(tables_.groups.weight);
    filter_.put(tables_.filter);
    noise_factor_.put(tables_.noise_factor);
    response_.put(tables_.response);
    queue_.wait();
  }

  // The device memory of a ping with `echoes` scatterers.
  std::uint64_t ping_bytes(std::uint64_t echoes, bool has_volumes) const {
    const std::uint64_t cells = std::uint64_t(beams()) * samples();
    const std::uint64_t sounds = std::max<std::uint64_t>(echoes, has_volumes ? cells : 0);
    const std::uint64_t grid = std::max<std::uint64_t>(points(), shifted_.points());
    const std::uint64_t shift = shifted_.points() > 0 ? shifted_.echo_bytes() + sizeof(Sound) : 0;
    const std::uint64_t moments =
        std::max(points() * 2 * tables_.groups.terms * tables_.groups.elements,
                 shifted_.points() * shifted_.group_moments());
    return elements() * (grid + bins() + samples()) * sizeof(Complex32) +
           array_beams_.ping_bytes(elements() * grid) + moments * sizeof(Complex32) +
           ElementGrids<Queue>::ping_bytes(grid) +
           cells * (2 * sizeof(Complex32) + (has_volumes ? sizeof(float) : 0)) +
           sounds * (sizeof(Sound) + ElementGrids<Queue>::sound_bytes()) +
           echoes * (sizeof(EchoRecord) + sizeof(ArrivalRecord) + sizeof(std::uint32_t) + shift) +
           power_.ping_bytes(echoes);
  }

  // Call upload() first, then compute(). The results series(), powers() and channels() stay on the
  // device.
  void upload(const PingBatch& batch, const Workers& workers) {
    upload(batch);
    shifted_.upload(batch, workers);
  }
  // Like upload(), where only keys and noise of the same pings are new.
  void renew(const PingBatch& batch) {
    pings_.put(batch.pings);
    volume_key_.put(batch.volume_key);
  }
  void compute(const PingBatch& batch) {
    make_spectra(batch, false);
    make_beams(batch, beams_);
    if (batch.wants_channels) make_channels(batch);
    if (!batch.wants_clean) return;
    if (batch.has_means) {
      make_spectra(batch, true);
      make_beams(batch, means_);
    }
    power_.run(batch, {echoes_.data(), energy_.data(), array_beams_.y_m(),
                       array_beams_.beam_cosine(), batch.has_means ? means_.data() : nullptr});
  }

  Complex32* series() const { return beams_.data(); }
  const float* powers() const { return power_.powers(); }
  const Complex32* channels() const { return channels_.data(); }  // [pings][elements][samples]

  // Releases the buffers of batches, results included.
  void drop_buffers() {
    for (auto* b : {&grid_, &spectrum_, &beams_, &means_, &channels_}) b->drop();
    for (auto* b : {&ping_of_, &first_echo_, &first_cell_, &first_shift_}) b->drop();
    for (auto* b : {&sounds_, &shifted_sounds_}) b->drop();
    energy_.drop();
    volume_key_.drop();
    echoes_.drop();
    arrivals_.drop();
    pings_.drop();
    grids_.drop_buffers();
    array_beams_.drop_buffers();
    shifted_.drop_buffers();
    power_.drop_buffers();
  }

 private:
  int beams() const { return setup_.sonar.beam_count; }
  int bins() const { return setup_.record.transform; }
  int samples() const { return setup_.record.samples; }
  int elements() const { return setup_.sonar.array->elements; }
  std::uint64_t points() const { return tables_.groups.points; }
  double points_per_sample() const { return static_cast<double>(points()) / bins(); }
  double points_per_s() const { return setup_.sonar.bandwidth_hz * points_per_sample(); }
  double sample_m() const { return sample_range_m(setup_.sonar, setup_.water, 1); }
  double width_in_wavelengths() const {
    return setup_.sonar.array->element_width_m / wavelength_m(setup_.sonar, setup_.water);
  }

  void upload(const PingBatch& batch) {
    const std::uint32_t pings = static_cast<std::uint32_t>(batch.pings.size());
    const std::uint32_t cells = beams() * samples();
    echo_begin_ = begin_of_pings(batch, batch.offset, batch.echoes.size());
    shift_begin_.clear();
    if (!batch.shifts.empty()) {
      shift_begin_ = begin_of_pings(batch, batch.shift_offset, batch.shifts.size());
    }
    cell_begin_.clear();
    for (std::uint32_t p = 0; p <= pings; ++p) cell_begin_.push_back(p * cells);
    echoes_.put(batch.echoes);
    arrivals_.put(batch.arrivals);
    ping_of_.put(batch.ping_of);
    pings_.put(batch.pings);
    volume_key_.put(batch.volume_key);
    energy_.put(batch.energy);
    first_echo_.put(echo_begin_);
    first_cell_.put(cell_begin_);
    first_shift_.put(shift_begin_);
  }

  // [pings + 1]: where pings begin, from `offset`.
  static std::vector<std::uint32_t> begin_of_pings(const PingBatch& batch,
                                                   std::span<const std::uint32_t> offset,
                                                   std::size_t count) {
    std::vector<std::uint32_t> begin;
    for (const BatchPing& ping : batch.pings) begin.push_back(offset[ping.first_offset]);
    begin.push_back(static_cast<std::uint32_t>(count));
    return begin;
  }

  // Makes the spectra of the elements' records, with volumes and noise unless `means_only`.
  void make_spectra(const PingBatch& batch, bool means_only) {
    const std::int64_t pings = batch.pings.size(), rows = pings * elements();
    const double source_pa_m = source_pressure_pa_m(setup_.sonar);
    grid_.need(rows * points());
    spectrum_.need(rows * bins());
    sounds_.need(batch.echoes.size());
    queue_.run(batch.echoes.size(),
               HearEchoes{echoes_.data(), arrivals_.data(), ping_of_.data(), pings_.data(),
                          setup_.sonar.frequency_hz, source_pa_m, points_per_s(),
                          width_in_wavelengths(), means_only, sounds_.data()});
    hear_shifts();
    gather(pings, {sounds_.data(), std::int64_t(batch.echoes.size()), first_echo_.data()}, false);
    if (!means_only && !batch.energy.empty()) {
      const std::int64_t cells = batch.energy.size();
      sounds_.need(cells);
      queue_.run(cells,
                 HearCells{energy_.data(), pings_.data(), volume_key_.data(),
                           array_beams_.beam_cosine(), source_pa_m, sample_m(), points_per_sample(),
                           width_in_wavelengths(), beams(), samples(), sounds_.data()});
      gather(pings, {sounds_.data(), cells, first_cell_.data()}, true);
    }
    queue_.transform(grid_.data(), tables_.groups.points, elements(), pings, FftDirection::forward);
    const bool has_noise = !means_only && batch.has_noise;
    if (has_noise) {
      queue_.run(rows * bins(), DrawNoise{pings_.data(), noise_factor_.data(), elements(), bins(),
                                          spectrum_.data()});
      queue_.transform(spectrum_.data(), bins(), elements(), pings, FftDirection::forward);
    }
    queue_.run(rows * bins(),
               FilterElements{grid_.data(), filter_.data(), response_.data(), elements(),
                              tables_.groups.points, bins(), has_noise, spectrum_.data()});
    add_shifts(pings);
  }

  // Afterwards, sounds_ contains the share at rest of Doppler echoes.
  void hear_shifts() {
    if (shifted_.count() == 0) return;
    shifted_sounds_.need(shifted_.count());
    const DopplerOnDevice all = shifted_.on_device();
    queue_.run(shifted_.count(),
               HearShifts{all.shifts, echoes_.data(), all.nodes, shifted_.points_per_s(),
                          sounds_.data(), all.value, all.place, shifted_sounds_.data()});
  }

  // Adds Doppler echoes to the spectra. Overwrites the grid.
  void add_shifts(std::int64_t pings) {
    if (shifted_.count() == 0) return;
    const DopplerOnDevice all = shifted_.on_device();
    const DeviceGroups& groups = shifted_.groups();
    const SoundList list{shifted_sounds_.data(), shifted_.count(), first_shift_.data()};
    const std::int64_t rows = pings * elements();
    grid_.need(rows * groups.points);
    shifted_.for_each_node(
        pings, [&](int node, const Complex32* filter, const unsigned char* uses) {
          queue_.run(list.count, WeighShifts<Sound>{all.value, all.place, all.nodes, node,
                                                    shifted_sounds_.data()});
          grids_.gather(pings, list, groups, shifted_.group_weight(), uses, false, grid_.data());
          queue_.transform(grid_.data(), groups.points, elements(), pings, FftDirection::forward);
          queue_.run(rows * bins(), AddNode{grid_.data(), filter, response_.data(), uses,
                                            elements(), groups.points, bins(), spectrum_.data()});
        });
  }

  void gather(std::int64_t pings, const SoundList& list, bool adds) {
    grids_.gather(pings, list, tables_.groups, point_weight_.data(), nullptr, adds, grid_.data());
  }

  // Overwrites the grid.
  void make_beams(const PingBatch& batch, DeviceBuffer<Complex32, Queue>& out) {
    const std::int64_t pings = batch.pings.size();
    out.need(pings * beams() * samples());
    array_beams_.form(pings, spectrum_.data(), grid_, out.data());
  }

  // Makes channels from the spectra. Overwrites the spectra.
  void make_channels(const PingBatch& batch) {
    const std::int64_t pings = batch.pings.size(), rows = pings * elements();
    channels_.need(rows * samples());
    queue_.transform(spectrum_.data(), bins(), elements(), pings, FftDirection::backward);
    queue_.run(rows * samples(), CutRecords{spectrum_.data(), samples(), bins(), channels_.data()});
  }

  Queue& queue_;
  SynthesisSetup setup_;
  ArrayTables tables_;
  ArrayPowerProgram<Queue> power_;
  DopplerEchoes<Queue> shifted_;
  ElementGrids<Queue> grids_;
  ArrayBeams<Queue> array_beams_;
  std::vector<std::uint32_t> echo_begin_, cell_begin_, shift_begin_;  // [pings + 1]
  DeviceBuffer<float, Queue> noise_factor_{queue_}, energy_{queue_};
  DeviceBuffer<PointWeights, Queue> point_weight_{queue_};
  DeviceBuffer<double, Queue> y_m_{queue_}, beam_cosine_{queue_};
  DeviceBuffer<Complex32, Queue> filter_{queue_}, response_{queue_}, steering_{queue_},
      grid_{queue_}, spectrum_{queue_}, wide_{queue_}, beams_{queue_}, means_{queue_},
      channels_{queue_};
  DeviceBuffer<std::uint32_t, Queue> ping_of_{queue_}, first_echo_{queue_}, first_cell_{queue_},
      first_shift_{queue_};
  DeviceBuffer<std::uint64_t, Queue> volume_key_{queue_};
  DeviceBuffer<EchoRecord, Queue> echoes_{queue_};
  DeviceBuffer<ArrivalRecord, Queue> arrivals_{queue_};
  DeviceBuffer<BatchPing, Queue> pings_{queue_};
  DeviceBuffer<Sound, Queue> sounds_{queue_}, shifted_sounds_{queue_};
};

}  // namespace ensonify
