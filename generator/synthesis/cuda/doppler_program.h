// The part of a program of beams that adds echoes which come back shifted.
#pragma once

#include "synthesis/cpu/fft.h"
#include "synthesis/cuda/shifted_echoes.h"

namespace ensonify {

template <class Queue>
class DopplerProgram {
 public:
  DopplerProgram(Queue& queue, const SynthesisSetup& setup)
      : queue_(queue), setup_(setup), shifted_(queue, setup) {}

  // As ShiftedEchoes.
  std::uint64_t points() const { return shifted_.points(); }
  static constexpr std::uint64_t echo_bytes() {
    return ShiftedEchoes<Queue>::echo_bytes() + sizeof(Complex32) + 2 * sizeof(float);
  }

  // The batch must last until the queue has waited.
  void upload(const PingBatch& batch, const Workers& workers) {
    shifted_.upload(batch, workers);
    if (shifted_.count() == 0) return;
    offset_.put(batch.shift_offset);
    weighed_.need(shifted_.count());
    offset_in_grid_.need(shifted_.count());
    first_.need(shifted_.count());
  }

  // After PlaceEchoes of the series, whose values become what is left at rest.
  void place(const EchoRecord* echoes, Complex32* at_rest) {
    if (shifted_.count() == 0) return;
    const ShiftsOnDevice all = shifted_.on_device();
    queue_.run(shifted_.count(),
               PlaceShifts{all.shifts, echoes, all.nodes, shifted_.points_per_s(),
                           shifted_.kernel().width, at_rest, all.value, all.place, placed()});
  }

  // To records [pings][sectors][transform], before they are transformed back.
  void add(const BatchPing* pings, std::int64_t ping_count, DeviceBuffer<Complex32, Queue>& grid,
           Complex32* record) {
    if (shifted_.count() == 0) return;
    const int sectors = setup_.sonar.beam_count, bins = setup_.record.transform;
    const ShiftsOnDevice all = shifted_.on_device();
    const DeviceKernel kernel = shifted_.kernel();
    const std::int64_t rows = ping_count * sectors;
    grid.need(rows * kernel.points);
    shifted_.for_each_node(ping_count, [&](int node, const Complex32* filter,
                                           const unsigned char* uses) {
      queue_.run(shifted_.count(),
                 WeighShifts{all.value, all.place, all.nodes, node, weighed_.data()});
      queue_.run(rows * kernel.points,
                 GatherNode{{placed(), pings, offset_.data(), kernel, sectors, grid.data()}, uses});
      queue_.transform(grid.data(), kernel.points, sectors, ping_count, FftDirection::forward);
      queue_.run(rows * bins,
                 AddNode{grid.data(), filter, nullptr, uses, sectors, kernel.points, bins, record});
    });
  }

  // Those of a batch.
  void drop_buffers() {
    shifted_.drop_buffers();
    offset_.drop();
    weighed_.drop();
    offset_in_grid_.drop();
    first_.drop();
  }

 private:
  PlacedEchoes placed() const { return {weighed_.data(), offset_in_grid_.data(), first_.data()}; }

  Queue& queue_;
  SynthesisSetup setup_;
  ShiftedEchoes<Queue> shifted_;
  DeviceBuffer<std::uint32_t, Queue> offset_{queue_};
  DeviceBuffer<Complex32, Queue> weighed_{queue_};
  DeviceBuffer<float, Queue> offset_in_grid_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
};

}  // namespace ensonify
