// What one thread of a device does for echoes that come back shifted; as beam_kernels.h. The node
// at rest is the series' own: shifted echoes stay in it with what they give to it. The other nodes
// come one after another, each with a grid of the shifted echoes alone.
//
//   PlaceShifts  copies the shifted echoes, and leaves their share at rest behind
//   WeighShifts  what they give to a node
//   GatherNode   these -> a point of a sector's grid
//   AddNode      spectrum of a node's grid -> spectrum of a record, of a sector or an element
#pragma once

#include <cstdint>

#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/records.h"

namespace ensonify {

// DopplerNodes there: place [degree + 1].
struct DeviceNodes {
  const double* place;
  int degree;
  double width;
};

// A shift among nodes first, first + step, ... of its band.
struct NodePlace {
  double at;     // in the band, in [0, 1)
  double scale;  // one over the sum of barycentric terms; 0: `at` is a node's own place
  int first, step;
};

ENSONIFY_HD inline double barycentric_term(const DeviceNodes& nodes, int q, double distance) {
  const double end = q == 0 || q == nodes.degree ? 0.5 : 1.0;
  return (q % 2 == 0 ? end : -end) / distance;
}

// As weights_at.
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
  const ShiftRecord* shifts;
  const EchoRecord* echoes;
  DeviceNodes nodes;
  double points_per_s;
  int width;
  Complex32* at_rest;  // [echoes]
  Complex32* value;    // [shifts], and so on
  NodePlace* node;
  PlacedEchoes out;  // without its value

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const ShiftRecord& shift = shifts[i];
    node[i] = node_place(nodes, shift.doppler);
    value[i] = at_rest[shift.echo];
    at_rest[shift.echo] = scaled(node_weight(nodes, node[i], 0), value[i]);
    place_echo(echoes[shift.echo].delay_s, points_per_s, width, out.offset[i], out.first[i]);
  }
};

struct WeighShifts {
  const Complex32* value;
  const NodePlace* place;
  DeviceNodes nodes;
  int node;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    out[i] = scaled(node_weight(nodes, place[i], node), value[i]);
  }
};

// In pings that use the node; of others the grid holds nothing that is asked for.
struct GatherNode {
  GatherSeries gather;
  const unsigned char* uses;  // [pings]

  ENSONIFY_HD void operator()(std::int64_t i) const {
    if (uses[i / gather.kernel.points / gather.sectors] != 0) gather(i);
  }
};

// record [pings][rows][transform] plus the filtered transforms of grids [pings][rows][points], in
// pings that use the node.
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
    record[i] = {record[i].re + part.re, record[i].im + part.im};
  }
};

}  // namespace ensonify
