// What all pings of an array share on a device, worked out on the host.
#pragma once

#include <vector>

#include "synthesis/array.h"
#include "synthesis/cpu/array_patterns.h"
#include "synthesis/cuda/beam_tables.h"
#include "synthesis/cuda/records.h"

namespace ensonify {

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

// Of expected power: echoes are dealt out to nodes in u, nodes to beams.
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
