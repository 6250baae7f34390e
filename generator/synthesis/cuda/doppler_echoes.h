// Doppler echoes of a batch on a device, with the nodes that they need. Tables are made if the
// setup expects Doppler, or when a batch first has a Doppler echo. In the code, a shift is a
// Doppler echo.
//
// Functors are as in beam_kernels.h. The node at rest is part of the series itself: Doppler echoes
// remain in the series with their weight at this node. The other nodes are processed one after
// another, each with a grid of the Doppler echoes only.
//
//   PlaceShifts    copies the Doppler echoes, and leaves their share at rest
//   WeighShifts    weighs them for a node
//   GatherNode     weighed echoes -> the grid of a sector
//   AddNode        spectrum of a node's grid -> spectrum of a record, of a beam node or an element
//   DopplerEchoes  the part that beam programs and array programs share
//   DopplerProgram the part of a beam program that adds Doppler echoes
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "core/parallel.h"
#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

// DopplerNodes on the device. place: [degree + 1].
struct DeviceNodes {
  const double* place;
  int degree;
  double width;
};

// The place of an echo among nodes first, first + step, ... of its band.
struct NodePlace {
  double at;     // in the band, in [0, 1)
  double scale;  // 1 / sum of barycentric terms; 0 if `at` is exactly at a node
  int first, step;
};

ENSONIFY_HD inline double barycentric_term(const DeviceNodes& nodes, int q, double distance) {
  const double end = q == 0 || q == nodes.degree ? 0.5 : 1.0;
  return (q % 2 == 0 ? end : -end) / distance;
}

// The equivalent of weights_at.
ENSONIFY_HD inline NodePlace node_place(const DeviceNodes& nodes, double doppler) {
  NodePlace place;
  place.step = doppler < 0 ? -1 : 1;
  const double bands = (doppler < 0 ? -doppler : doppler) / nodes.width;
  const int band = static_cast<int>(bands);
  place.at = bands - band;
  place.first = place.step * band * nodes.degree;
  place.scale = 0;
  double sum = 0;
  for (int q = 0; q <= nodes.degree; ++q) {
    const double distance = place.at - nodes.place[q];
    if (distance == 0) return place;
    sum += barycentric_term(nodes, q, distance);
  }
  place.scale = 1 / sum;
  return place;
}

ENSONIFY_HD inline double node_weight(const DeviceNodes& nodes, const NodePlace& place, int node) {
  const int q = place.step * (node - place.first);
  if (q < 0 || q > nodes.degree) return 0;
  const double distance = place.at - nodes.place[q];
  if (place.scale == 0) return distance == 0 ? 1 : 0;
  return place.scale * barycentric_term(nodes, q, distance);
}

ENSONIFY_HD inline Complex32 scaled(double factor, Complex32 z) {
  return {static_cast<float>(factor * z.re), static_cast<float>(factor * z.im)};
}

struct PlaceShifts {
  const DopplerRecord* shifts;
  const EchoRecord* echoes;
  DeviceNodes nodes;
  double points_per_s;
  int width;
  Complex32* at_rest;  // [echoes]
  Complex32* value;    // [shifts], as are the next two
  NodePlace* node;
  PlacedEchoes out;  // all but the value

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const DopplerRecord& shift = shifts[i];
    node[i] = node_place(nodes, shift.doppler);
    value[i] = at_rest[shift.echo];
    at_rest[shift.echo] = scaled(node_weight(nodes, node[i], 0), value[i]);
    place_echo(echoes[shift.echo].delay_s, points_per_s, width, out.offset[i], out.first[i]);
  }
};

ENSONIFY_HD inline Complex32& value_of(Complex32& echo) { return echo; }

// `Echo` is any type with a value_of().
template <class Echo>
struct WeighShifts {
  const Complex32* value;
  const NodePlace* place;
  DeviceNodes nodes;
  int node;
  Echo* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    value_of(out[i]) = scaled(node_weight(nodes, place[i], node), value[i]);
  }
};

// Writes the grid of pings that use the node. The grid of other pings is undefined.
struct GatherNode {
  GatherSeries gather;
  const unsigned char* uses;  // [pings]

  ENSONIFY_HD void operator()(std::int64_t i) const {
    if (uses[i / kGridLanes / gather.sectors] != 0) gather(i);
  }
};

// Adds the filtered transforms of grids [pings][rows][points] to record [pings][rows][transform],
// for pings that use the node.
struct AddNode {
  const Complex32* grid;
  const Complex32* filter;    // [transform], bin 0 first
  const Complex32* response;  // [rows]; null: 1
  const unsigned char* uses;  // [pings]
  int rows, points, transform;
  Complex32* record;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t row = i / transform;
    if (uses[row / rows] == 0) return;
    const auto k = static_cast<int>(i % transform);
    const int at = k < transform / 2 ? k : points - transform + k;
    Complex32 part = product(grid[row * points + at], filter[k]);
    if (response != nullptr) part = product(response[row % rows], part);
    record[i] += part;
  }
};

// Device arrays for functors that work on Doppler echoes.
struct DopplerOnDevice {
  const DopplerRecord* shifts;
  DeviceNodes nodes;
  Complex32* value;  // [shifts], without the weight of a node
  NodePlace* place;  // [shifts]
};

template <class Queue>
class DopplerEchoes {
 public:
  DopplerEchoes(Queue& queue, const SynthesisSetup& setup) : queue_(queue), setup_(setup) {
    if (setup.min_doppler != 0 || setup.max_doppler != 0) need_tables();
  }

  // The points of a node's grid, or 0 if the setup expects no Doppler and no batch has had any so
  // far.
  std::uint64_t points() const { return tables_ ? tables_->spread.points : 0; }
  // The moments of a cell of an array's grid, for all elements of a group.
  std::uint64_t group_moments() const {
    return tables_ ? 2 * tables_->groups.terms * tables_->groups.elements : 0;
  }
  // Device memory for each Doppler echo.
  static constexpr std::uint64_t echo_bytes() {
    return sizeof(DopplerRecord) + sizeof(NodePlace) + sizeof(Complex32);
  }

  // The batch must last until the queue has waited.
  void upload(const PingBatch& batch, const Workers& workers) {
    count_ = static_cast<std::int64_t>(batch.shifts.size());
    used_ = {};
    if (count_ == 0) return;
    need_tables();
    node_place_.put(tables_->place);
    coefficient_.put(tables_->spread.coefficient);
    group_weight_.put(tables_->groups.weight);
    used_ = nodes_in_use(tables_->nodes, batch, workers);
    for (const int node : used_.node) need_filter(node);
    uses_.put(used_.uses);
    shifts_.put(batch.shifts);
    value_.need(count_);
    place_.need(count_);
  }

  // All functions after count() need an upload with count() > 0.
  std::int64_t count() const { return count_; }
  DopplerOnDevice on_device() const {
    const DeviceNodes nodes{node_place_.data(), tables_->nodes.degree, tables_->nodes.width};
    return {shifts_.data(), nodes, value_.data(), place_.data()};
  }
  DeviceKernel kernel() const {
    const DeviceSpread& spread = tables_->spread;
    return {coefficient_.data(), spread.width, spread.degree, spread.points};
  }
  // For an array, and their weights on the device.
  const DeviceGroups& groups() const { return tables_->groups; }
  const PointWeights* group_weight() const { return group_weight_.data(); }
  double points_per_s() const {
    return setup_.sonar.bandwidth_hz * tables_->spread.points / setup_.record.transform;
  }

  // Calls add(node, filter, uses) for every node whose pulse is in the band. uses: [pings].
  template <class Add>
  void for_each_node(std::int64_t pings, const Add& add) const {
    for (std::size_t i = 0; i < used_.node.size(); ++i) {
      const auto& filter = filters_.at(used_.node[i]);
      if (filter != nullptr) add(used_.node[i], filter->data(), uses_.data() + i * pings);
    }
  }

  // Releases the buffers of batches.
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
  std::map<int, std::unique_ptr<Filter>> filters_;  // null if the pulse is outside of the band
  std::int64_t count_ = 0;
  NodesInUse used_;
  DeviceBuffer<double, Queue> node_place_{queue_};
  DeviceBuffer<float, Queue> coefficient_{queue_};
  DeviceBuffer<PointWeights, Queue> group_weight_{queue_};
  DeviceBuffer<unsigned char, Queue> uses_{queue_};
  DeviceBuffer<DopplerRecord, Queue> shifts_{queue_};
  DeviceBuffer<Complex32, Queue> value_{queue_};
  DeviceBuffer<NodePlace, Queue> place_{queue_};
};

template <class Queue>
class DopplerProgram {
 public:
  DopplerProgram(Queue& queue, const SynthesisSetup& setup)
      : queue_(queue), setup_(setup), shifted_(queue, setup) {}

  // As in DopplerEchoes.
  std::uint64_t points() const { return shifted_.points(); }
  static constexpr std::uint64_t echo_bytes() {
    return DopplerEchoes<Queue>::echo_bytes() + sizeof(Complex32) + 2 * sizeof(float);
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

  // Runs after PlaceEchoes of the series, and reduces its values to the share at rest.
  void place(const EchoRecord* echoes, Complex32* at_rest) {
    if (shifted_.count() == 0) return;
    const DopplerOnDevice all = shifted_.on_device();
    queue_.run(shifted_.count(),
               PlaceShifts{all.shifts, echoes, all.nodes, shifted_.points_per_s(),
                           shifted_.kernel().width, at_rest, all.value, all.place, placed()});
  }

  // Adds Doppler echoes to record [pings][beam nodes][transform], before its inverse transform.
  // to_beam_nodes(length) spreads `grid` [pings][sectors][length] over the beam nodes.
  template <class ToBeamNodes>
  void add(const BatchPing* pings, std::int64_t ping_count, int beam_nodes,
           DeviceBuffer<Complex32, Queue>& grid, const ToBeamNodes& to_beam_nodes,
           Complex32* record) {
    if (shifted_.count() == 0) return;
    const int sectors = setup_.sonar.beam_count, bins = setup_.record.transform;
    const DopplerOnDevice all = shifted_.on_device();
    const DeviceKernel kernel = shifted_.kernel();
    grid.need(ping_count * sectors * kernel.points);
    shifted_.for_each_node(ping_count, [&](int node, const Complex32* filter,
                                           const unsigned char* uses) {
      queue_.run(shifted_.count(),
                 WeighShifts<Complex32>{all.value, all.place, all.nodes, node, weighed_.data()});
      queue_.run(ping_count * sectors * kGridLanes,
                 GatherNode{{placed(), pings, offset_.data(), kernel, sectors, grid.data()}, uses});
      Complex32* spread = to_beam_nodes(kernel.points);
      queue_.transform(spread, kernel.points, beam_nodes, ping_count, FftDirection::forward);
      queue_.run(ping_count * beam_nodes * bins,
                 AddNode{spread, filter, nullptr, uses, beam_nodes, kernel.points, bins, record});
    });
  }

  // Releases the buffers of batches.
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
  DopplerEchoes<Queue> shifted_;
  DeviceBuffer<std::uint32_t, Queue> offset_{queue_};
  DeviceBuffer<Complex32, Queue> weighed_{queue_};
  DeviceBuffer<float, Queue> offset_in_grid_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
};

}  // namespace ensonify
