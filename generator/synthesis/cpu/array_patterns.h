// Power patterns of an array's beams at nodes across u.
//
//   PowerGrid      make_power_grid          nodes, and cells of u between them
//   make_array_power_plan                   powers of echoes to series of nodes
//   PatternBlock   pattern_blocks  make_patterns            nodes to beams
#pragma once

#include <memory>
#include <vector>

#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

constexpr int kCellsPerNode = 24;
constexpr int kPatternTaps = 4;

// Echoes of one cell share their weights over kPatternTaps nodes.
struct PowerGrid {
  double spacing_u = 0;
  int first = 0, nodes = 0;  // node q at u = (first + q) spacing_u; an even number
  int cells = 0;             // kCellsPerNode between neighbours

  double node_u(int q) const { return (first + q) * spacing_u; }
  int cell_of(double u) const;
};

PowerGrid make_power_grid(const SynthesisSetup& setup);

std::unique_ptr<const NodePlan> make_array_power_plan(const SynthesisTables& tables,
                                                      const PowerGrid& grid);

// Samples that share the patterns of their middle.
struct PatternBlock {
  int begin = 0, end = 0;
  std::vector<float> packed;  // |pattern|^2 E^2, as product() wants [beams, padded][nodes]

  double middle() const;  // in samples
};

// All samples, from the last to the first; nothing packed.
std::vector<PatternBlock> pattern_blocks(const SynthesisSetup& setup);

std::vector<PatternBlock> make_patterns(const SynthesisSetup& setup, const Kernels& kernels,
                                        const PowerGrid& grid);
std::uint64_t pattern_bytes(const SynthesisSetup& setup, const PowerGrid& grid);

}  // namespace ensonify
