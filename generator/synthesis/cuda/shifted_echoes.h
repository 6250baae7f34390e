// The shifted echoes of a batch on a device, with the nodes that they need: what programs of beams
// and of arrays share. Nothing is worked out for them before a batch has one.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "core/parallel.h"
#include "synthesis/cuda/doppler_kernels.h"
#include "synthesis/cuda/doppler_tables.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// What all that works on shifted echoes takes.
struct ShiftsOnDevice {
  const ShiftRecord* shifts;
  DeviceNodes nodes;
  Complex32* value;  // [shifts], before a node's weight
  NodePlace* place;  // [shifts]
};

template <class Queue>
class ShiftedEchoes {
 public:
  ShiftedEchoes(Queue& queue, const SynthesisSetup& setup) : queue_(queue), setup_(setup) {
    if (setup.min_doppler != 0 || setup.max_doppler != 0) need_tables();
  }

  // Of a node's grid, where echoes may be shifted or have been; 0 elsewhere.
  std::uint64_t points() const { return tables_ ? tables_->spread.points : 0; }
  // Of each on the device.
  static constexpr std::uint64_t echo_bytes() {
    return sizeof(ShiftRecord) + sizeof(NodePlace) + sizeof(Complex32);
  }

  // The batch must last until the queue has waited.
  void upload(const PingBatch& batch, const Workers& workers) {
    count_ = static_cast<std::int64_t>(batch.shifts.size());
    used_ = {};
    if (count_ == 0) return;
    need_tables();
    node_place_.put(tables_->place);
    coefficient_.put(tables_->spread.coefficient);
    used_ = nodes_in_use(tables_->nodes, batch, workers);
    for (const int node : used_.node) need_filter(node);
    uses_.put(used_.uses);
    shifts_.put(batch.shifts);
    value_.need(count_);
    place_.need(count_);
  }

  // The rest needs an upload of some.
  std::int64_t count() const { return count_; }
  ShiftsOnDevice on_device() const {
    const DeviceNodes nodes{node_place_.data(), tables_->nodes.degree, tables_->nodes.width};
    return {shifts_.data(), nodes, value_.data(), place_.data()};
  }
  DeviceKernel kernel() const {
    const DeviceSpread& spread = tables_->spread;
    return {coefficient_.data(), spread.width, spread.degree, spread.points};
  }
  double points_per_s() const {
    return setup_.sonar.bandwidth_hz * tables_->spread.points / setup_.record.transform;
  }

  // add(node, its filter, which pings use it) for every node that is heard.
  template <class Add>
  void for_each_node(std::int64_t pings, const Add& add) const {
    for (std::size_t i = 0; i < used_.node.size(); ++i) {
      const auto& filter = filters_.at(used_.node[i]);
      if (filter != nullptr) add(used_.node[i], filter->data(), uses_.data() + i * pings);
    }
  }

  // Those of a batch.
  void drop_buffers() {
    uses_.drop();
    shifts_.drop();
    value_.drop();
    place_.drop();
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

  Queue& queue_;
  SynthesisSetup setup_;
  std::optional<DopplerTables> tables_;
  std::map<int, std::unique_ptr<Filter>> filters_;  // null where the pulse has left the band
  std::int64_t count_ = 0;
  NodesInUse used_;
  DeviceBuffer<double, Queue> node_place_{queue_};
  DeviceBuffer<float, Queue> coefficient_{queue_};
  DeviceBuffer<unsigned char, Queue> uses_{queue_};
  DeviceBuffer<ShiftRecord, Queue> shifts_{queue_};
  DeviceBuffer<Complex32, Queue> value_{queue_};
  DeviceBuffer<NodePlace, Queue> place_{queue_};
};

}  // namespace ensonify
