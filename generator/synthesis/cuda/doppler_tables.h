// Spectra of shifted pulses for a device program, worked out on the host: S_eta is a sum over the
// nodes of cpu/doppler_nodes.h, and what shifted echoes give to every node but that at rest goes
// through one spreading kernel that suits any spectrum.
//
//   DopplerTables  make_doppler_tables
//   node_filter    of the kernel's grid, of one node
//   NodesInUse     nodes_in_use: those that the pings of a batch need
#pragma once

#include <span>
#include <vector>

#include "acoustics/pulse.h"
#include "core/parallel.h"
#include "synthesis/cpu/doppler_nodes.h"
#include "synthesis/cuda/beam_tables.h"
#include "synthesis/cuda/ping_batch.h"

namespace ensonify {

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

}  // namespace ensonify
