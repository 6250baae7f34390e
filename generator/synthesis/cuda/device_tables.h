// What all pings of a setup share on a device, worked out on the host.
//
//   DeviceSpread  spread_of  series_spread      a spreading kernel with what undoes it
//   BeamTables    make_beam_tables              of sectors
//   DopplerTables  make_doppler_tables          of shifted pulses: S_eta is a sum over the nodes of
//                 cpu/doppler_synthesis.h, and what shifted echoes give to every node but that at
//                 rest goes through one spreading kernel that suits any spectrum
//   node_filter   of the kernel's grid, of one node
//   NodesInUse    nodes_in_use                  those that the pings of a batch need
//   ArrayTables  ArrayPowerTables  make_array_tables  make_array_power_tables
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "acoustics/pulse.h"
#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/array_power.h"
#include "synthesis/cpu/doppler_synthesis.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/cuda/ping_batch.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

inline Complex32 narrow(std::complex<double> z) {
  return {static_cast<float>(z.real()), static_cast<float>(z.imag())};
}

// A spreading kernel with what undoes it: the grid's spectrum times `filter` is the record's.
struct DeviceSpread {
  int points = 0, width = 0, degree = 0;
  std::vector<float> coefficient;  // as DeviceKernel
  // [transform], bin 0 first. upper_filter: of powers, what falls on a bin from a period above it.
  std::vector<Complex32> filter, upper_filter, cell_filter;
};

struct BeamTables {
  DeviceSpread series, power;
  // [kBeamsAThread + 2 beams - 1 + kBeamsAThread]: of sector s in beam j at
  // kBeamsAThread + s - j + beams - 1, zero at both ends.
  std::vector<float> weight, power_weight;
  std::vector<float> scale, power_scale;  // [beams]
};

// A kernel as a device takes it, filters still empty; and one for records of so a spectrum, whose
// echoes err by at most `error`: single precision leaves 1e-6.
DeviceSpread spread_of(const SpreadKernel& kernel, int transform);
DeviceSpread series_spread(const std::vector<std::complex<double>>& spectrum, double error = 3e-6);

// Records agree with the CPU's to 1e-5 of their norm, expected powers to 0.1 dB where they lie
// within 40 dB of the largest.
BeamTables make_beam_tables(const SynthesisSetup& setup);

struct DopplerTables {
  DopplerPulse pulse;
  DopplerNodes nodes;
  std::vector<double> place;  // [degree + 1]: of the nodes of a band, from 0 to 1
  DeviceSpread spread;        // its filters are those of a flat spectrum
  double loudest = 0;         // largest |S_m| at rest
};

// For setups with can_shift; others end the program.
DopplerTables make_doppler_tables(const SynthesisSetup& setup);

// [transform], bin 0 first. Empty where the pulse has left the band.
std::vector<Complex32> node_filter(const DopplerTables& tables, int node);

// Without node 0.
struct NodesInUse {
  std::vector<int> node;            // rising
  std::vector<unsigned char> uses;  // [nodes][pings]: whether an echo of the ping lies beside it
};
NodesInUse nodes_in_use(const DopplerNodes& nodes, const PingBatch& batch, const Workers& workers);

struct ArrayTables {
  DeviceSpread series;
  std::vector<double> y_m;                  // [elements]
  std::vector<float> weight, noise_factor;  // [elements]; noise: an element's rms over a beam's
  std::vector<Complex32> response;          // [elements]
  std::vector<double> beam_cosine;          // [beams], of the beams' axes and the sectors
  std::vector<Complex32> steering;          // [beams][elements], weight turned by the delay
  // As BeamTaps, `begin` in [0, 2 M).
  std::vector<float> correction;
  std::vector<std::int32_t> begin;
  std::vector<float> tap;
};

// The tables of expected power: echoes are dealt out to nodes in u, nodes to beams.
struct ArrayPowerTables {
  PowerGrid grid;
  DeviceSpread power;                     // without filters
  std::vector<Complex32> filter;          // [rows or 1][lower, upper][M]
  int row_filters = 0;                    // 1, or as many as rows
  std::vector<float> cell_weight;         // [cells][kPatternTaps]
  std::vector<double> node_cosine;        // [nodes]
  std::vector<float> node_heard;          // [nodes], E^2
  std::vector<Complex32> received;        // [elements], weight times response
  std::vector<SectorRecord> sectors;      // by row, then sector
  std::vector<std::uint32_t> row_offset;  // [rows + 1], among these
  std::vector<PatternBlock> blocks;
};

ArrayTables make_array_tables(const SynthesisSetup& setup);
ArrayPowerTables make_array_power_tables(const SynthesisSetup& setup);

}  // namespace ensonify
