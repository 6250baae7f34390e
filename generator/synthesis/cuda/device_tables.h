// Tables that all pings of a setup share on a device, computed on the host.
//
//   DeviceSpread  spread_of  series_spread      a spreading kernel with the filters that undo it
//   DeviceMixing  BeamTables  make_beam_tables  for beam cells
//   DeviceGroups                                a spreading kernel for groups of elements
//   DopplerTables  make_doppler_tables          for Doppler: S_eta is a sum over the nodes of
//                 cpu/doppler_nodes.h, and all nodes except the one at rest share a spreading
//                 kernel that suits any spectrum
//   node_filter   the filter of one node for the kernel's grid
//   NodesInUse    nodes_in_use                  the nodes that the pings of a batch need
//   ArrayNodeTables  ArrayTables  make_array_tables
//   ArrayPowerTables  make_array_power_tables
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "acoustics/pulse.h"
#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/array_power.h"
#include "synthesis/cpu/doppler_nodes.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

inline Complex32 narrow(std::complex<double> z) {
  return {static_cast<float>(z.real()), static_cast<float>(z.imag())};
}

// A spreading kernel with the filters that undo it: the grid's spectrum times `filter` is the
// spectrum of the record.
struct DeviceSpread {
  int points = 0, width = 0, degree = 0;
  std::vector<float> coefficient;  // as in DeviceKernel
  // [transform], bin 0 first. upper_filter is for powers: the part from one period above each bin.
  std::vector<Complex32> filter, upper_filter, cell_filter;
};

// What leads from beam cells to beams (cpu/beam_nodes.h) on a device.
struct DeviceMixing {
  int nodes = 0;                          // an even number
  std::vector<SectorRecord> cells;        // sorted by pairs of nodes, then by cells
  std::vector<std::uint32_t> row_offset;  // [nodes / 2 + 1], index into `cells`
  std::vector<BeamWeights> weight;        // [ceil(beams / kBeamsAThread)][nodes], with the scales
};

struct BeamTables {
  DeviceSpread series, power;
  DeviceMixing mixing, power_mixing;
};

// spread_of converts a kernel for a device and leaves the filters empty. series_spread makes a
// kernel for records with a spectrum, with an error of echoes of at most `error`. Single precision
// has errors of 1e-6.
DeviceSpread spread_of(const SpreadKernel& kernel, int transform);
DeviceSpread series_spread(const std::vector<std::complex<double>>& spectrum, double error = 3e-6);

// With these tables, records agree with those of the CPU backend to 1e-5 of their norm. Expected
// powers within 40 dB of the largest agree to 0.1 dB.
BeamTables make_beam_tables(const SynthesisSetup& setup);

// The spreading kernel of an array's grids (ElementGroups of cpu/array_records.h).
struct DeviceGroups {
  int points = 0, width = 0;  // of the time grid and its kernel
  int terms = 0;              // half the number of moments
  int elements = 0;           // of a group
  float per_reach = 0;
  double exact_range_m = 0;
  // [width + kPointsAThread - 1][2 terms]: of the moments of the cells that reach neighboring
  // points, the cell furthest before them first.
  std::vector<PointWeights> weight;
};

struct DopplerTables {
  DopplerPulse pulse;
  DopplerNodes nodes;
  std::vector<double> place;  // [degree + 1]: places of nodes in a band, from 0 to 1
  DeviceSpread spread;        // with the filters of a flat spectrum
  DeviceGroups groups;        // of the same kernel, for an array
  double loudest = 0;         // largest |S_m| at rest
};

// Needs a setup for which can_shift is true, and terminates the program otherwise.
DopplerTables make_doppler_tables(const SynthesisSetup& setup);

// [transform], bin 0 first. Empty if the pulse is outside of the band.
std::vector<Complex32> node_filter(const DopplerTables& tables, int node);

// Does not include node 0.
struct NodesInUse {
  std::vector<int> node;            // in increasing order
  std::vector<unsigned char> uses;  // [nodes][pings]: whether the ping has an echo near it
};
NodesInUse nodes_in_use(const DopplerNodes& nodes, const PingBatch& batch, const Workers& workers);

// ArrayNodes of cpu/array_nodes.h in single precision.
struct ArrayNodeTables {
  int count = 0, orders = 0;  // 0: there are no nodes
  int near_samples = 0;       // the first samples, which are sums of all elements
  int grid = 0, first_row = 0, block_bins = 0, blocks = 0;
  std::vector<ElementWeight> element_weight;  // [elements]
  std::vector<Complex32> row_phase;           // [reached rows]
  std::vector<std::int32_t> base;             // [count][blocks]
  std::vector<float> steer_weight;            // [count][blocks][kSteerTaps][kSteerDegree + 1]
  std::vector<NodePiece> pieces;
  std::vector<Complex32> coefficient;  // of all stretches, [beams][orders][taps][degree + 1]
  std::vector<std::int32_t> first;     // [stretches][beams]
  std::vector<float> time;             // [samples], -1 .. 1 over each stretch
};

struct ArrayTables {
  DeviceGroups groups;
  std::vector<Complex32> filter;            // [transform], bin 0 first
  std::vector<double> y_m;                  // [elements]
  std::vector<float> weight, noise_factor;  // [elements]; noise: rms of an element / rms of a beam
  std::vector<Complex32> response;          // [elements]
  std::vector<double> beam_cosine;          // [beams], of the axes of beams and beam cells
  std::vector<Complex32> steering;          // [beams][elements], weight with the phase of the delay
  // As in BeamTaps, but with `begin` in [0, 2 M).
  std::vector<float> correction;
  std::vector<std::int32_t> begin;
  std::vector<ElementTaps> tap;
  ArrayNodeTables nodes;
};

// The tables for expected power, from echoes to nodes in u, and from nodes to beams.
struct ArrayPowerTables {
  PowerGrid grid;
  DeviceSpread power;                     // without filters
  std::vector<Complex32> filter;          // [rows or 1][lower, upper][M]
  int row_filters = 0;                    // 1, or the number of rows
  std::vector<float> cell_weight;         // [cells][kPatternTaps]
  std::vector<double> node_cosine;        // [nodes]
  std::vector<float> node_heard;          // [nodes], E^2
  std::vector<Complex32> received;        // [elements], weight times response
  std::vector<SectorRecord> sectors;      // sorted by row, then by sector
  std::vector<std::uint32_t> row_offset;  // [rows + 1], index into `sectors`
  std::vector<PatternBlock> blocks;
};

// With these tables, records agree with those of the reference to 1e-5 of their norm.
ArrayTables make_array_tables(const SynthesisSetup& setup);
ArrayPowerTables make_array_power_tables(const SynthesisSetup& setup);

}  // namespace ensonify
