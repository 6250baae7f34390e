// The expected power of an array's beams, from their power patterns at nodes across u.
//
// |h_j(t)|^2 of a scatterer is approximated by the beam's power pattern at the scatterer's
// direction and the range of the sample, times the power of the beam's envelope. This is exact for
// a scatterer on the beam's axis at its focus. It neglects that different paths to the elements
// spread an echo in time. Relative L2 error against the definition: 1 % with steering by delay and
// focus, up to 11 % with steering by phase and no focus.
//
//   PowerGrid      make_power_grid                nodes, and cells of u between them
//   make_array_power_plan                         from powers of echoes to time series of nodes
//   PatternBlock   pattern_blocks  make_patterns  from nodes to beams
//   ArrayPower     make_array_power
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
  int first = 0, nodes = 0;  // node q at u = (first + q) spacing_u; an even number of nodes
  int cells = 0;             // kCellsPerNode between neighboring nodes

  double node_u(int q) const { return (first + q) * spacing_u; }
  int cell_of(double u) const;
};

PowerGrid make_power_grid(const SynthesisSetup& setup);

std::unique_ptr<const NodePlan> make_array_power_plan(const SynthesisTables& tables,
                                                      const PowerGrid& grid);

// A block of samples that share the patterns of its middle.
struct PatternBlock {
  int begin = 0, end = 0;
  std::vector<float> packed;  // |pattern|^2 E^2, [beams, padded][nodes] in the order of product()

  double middle() const;  // in samples
};

// The blocks of all samples, from the last to the first. `packed` stays empty.
std::vector<PatternBlock> pattern_blocks(const SynthesisSetup& setup);

std::vector<PatternBlock> make_patterns(const SynthesisSetup& setup, const Kernels& kernels,
                                        const PowerGrid& grid);
std::uint64_t pattern_bytes(const SynthesisSetup& setup, const PowerGrid& grid);

class ArrayPower {
 public:
  virtual ~ArrayPower() = default;
  virtual SynthesisMemory memory() const = 0;
  // power: [beams][samples], S0^2 sum variance gain^2 |h|^2, volumes included.
  virtual void diffuse(const PingTask& task, SampleArray<float>& power,
                       const Workers& workers) const = 0;
};

std::unique_ptr<const ArrayPower> make_array_power(const SynthesisTables& tables);

}  // namespace ensonify
