// The part of a device program that adds echoes which come back shifted. Nothing of it runs, and
// nothing is worked out for it, before a batch has one.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "core/parallel.h"
#include "synthesis/cpu/fft.h"
#include "synthesis/cuda/doppler_kernels.h"
#include "synthesis/cuda/doppler_tables.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

template <class Queue>
class DopplerProgram {
 public:
  DopplerProgram(Queue& queue, const SynthesisSetup& setup) : queue_(queue), setup_(setup) {
    if (setup.min_doppler != 0 || setup.max_doppler != 0) need_tables();
  }

  // Of the grids, where echoes may be shifted or have been; 0 elsewhere.
  std::uint64_t points() const { return tables_ ? tables_->spread.points : 0; }
  // Of a shifted echo on the device.
  static constexpr std::uint64_t echo_bytes() {
    return sizeof(ShiftRecord) + sizeof(NodePlace) + 2 * sizeof(Complex32) + 2 * sizeof(float);
  }

  // The batch must last until the queue has waited.
  void upload(const PingBatch& batch, const Workers& workers) {
    count_ = static_cast<std::int64_t>(batch.shifts.size());
    used_ = {};
    if (count_ == 0) return;
    need_tables();
    place_.put(tables_->place);
    coefficient_.put(tables_->spread.coefficient);
    used_ = nodes_in_use(tables_->nodes, batch, workers);
    for (const int node : used_.node) need_filter(node);
    uses_.put(used_.uses);
    shifts_.put(batch.shifts);
    offset_.put(batch.shift_offset);
    value_.need(count_);
    weighed_.need(count_);
    node_.need(count_);
    offset_in_grid_.need(count_);
    first_.need(count_);
  }

  // After PlaceEchoes of the series, whose values become what is left at rest.
  void place(const EchoRecord* echoes, Complex32* at_rest) {
    if (count_ == 0) return;
    const double points_per_s =
        setup_.sonar.bandwidth_hz * tables_->spread.points / setup_.record.transform;
    queue_.run(count_,
               PlaceShifts{shifts_.data(), echoes, nodes(), points_per_s, tables_->spread.width,
                           at_rest, value_.data(), node_.data(), placed()});
  }

  // To records [pings][sectors][transform], before they are transformed back.
  void add(const PingRecord* pings, std::int64_t ping_count, DeviceBuffer<Complex32, Queue>& grid,
           Complex32* record) {
    if (count_ == 0) return;
    const int sectors = setup_.sonar.beam_count, bins = setup_.record.transform;
    const DeviceSpread& spread = tables_->spread;
    const DeviceKernel kernel{coefficient_.data(), spread.width, spread.degree, spread.points};
    const std::int64_t rows = ping_count * sectors;
    grid.need(rows * kernel.points);
    for (std::size_t i = 0; i < used_.node.size(); ++i) {
      const auto& filter = filters_.at(used_.node[i]);
      if (filter == nullptr) continue;
      queue_.run(count_,
                 WeighShifts{value_.data(), node_.data(), nodes(), used_.node[i], weighed_.data()});
      const unsigned char* uses = uses_.data() + i * ping_count;
      queue_.run(rows * kernel.points,
                 GatherNode{{placed(), pings, offset_.data(), kernel, sectors, grid.data()}, uses});
      queue_.transform(grid.data(), kernel.points, sectors, ping_count, FftDirection::forward);
      queue_.run(rows * bins,
                 AddNode{grid.data(), filter->data(), uses, sectors, kernel.points, bins, record});
    }
  }

  // Those of a batch.
  void drop_buffers() {
    uses_.drop();
    shifts_.drop();
    offset_.drop();
    value_.drop();
    weighed_.drop();
    node_.drop();
    offset_in_grid_.drop();
    first_.drop();
  }

 private:
  using Filter = DeviceBuffer<Complex32, Queue>;

  void need_tables() {
    if (!tables_) tables_ = make_doppler_tables(setup_);
  }
  void need_filter(int node) {
    if (filters_.contains(node)) return;
    const std::vector<Complex32> values = node_filter(*tables_, node);
    std::unique_ptr<Filter> filter;
    if (!values.empty()) {
      filter = std::make_unique<Filter>(queue_);
      filter->put(values);
      queue_.wait();
    }
    filters_.emplace(node, std::move(filter));
  }
  DeviceNodes nodes() const { return {place_.data(), tables_->nodes.degree, tables_->nodes.width}; }
  PlacedEchoes placed() const { return {weighed_.data(), offset_in_grid_.data(), first_.data()}; }

  Queue& queue_;
  SynthesisSetup setup_;
  std::optional<DopplerTables> tables_;
  std::map<int, std::unique_ptr<Filter>> filters_;  // null where the pulse has left the band
  std::int64_t count_ = 0;                          // of shifted echoes
  NodesInUse used_;
  DeviceBuffer<double, Queue> place_{queue_};
  DeviceBuffer<float, Queue> coefficient_{queue_}, offset_in_grid_{queue_};
  DeviceBuffer<unsigned char, Queue> uses_{queue_};
  DeviceBuffer<ShiftRecord, Queue> shifts_{queue_};
  DeviceBuffer<std::uint32_t, Queue> offset_{queue_};
  DeviceBuffer<Complex32, Queue> value_{queue_}, weighed_{queue_};
  DeviceBuffer<NodePlace, Queue> node_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
};

}  // namespace ensonify
