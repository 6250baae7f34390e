// Echoes with Doppler on the fast path. An echo is deposited once for each node of its band, with
// the node's weight. The records of all nodes have the same beams, so that they are added up before
// the last transform, and beams are mixed once.
//
//   NodeFilters   the filters of all nodes, made when echoes first need them
//   ShiftedSet    the echoes of one node
//   place_sets    chooses the sets of a ping, and places its echoes on their grids
//   weigh_sets    the values of the echoes
//   echo_sets     the sets for transform_nodes
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "synthesis/cpu/doppler_nodes.h"
#include "synthesis/cpu/node_sums.h"

namespace ensonify {

// The filter of a node. Without a grid, the pulse is outside of the band, or no kernel holds the
// tolerance.
struct NodeFilter {
  bool is_audible = false;
  std::unique_ptr<GridFilter> grid;
};

// Several threads may use it at once.
class NodeFilters {
 public:
  const NodeFilter& at(const NodeSpectra& spectra, int node, double tolerance);

 private:
  std::mutex mutex_;
  std::map<int, NodeFilter> made_;
};

struct ShiftedSet {
  int node = 0;
  const GridFilter* grid = nullptr;
  AlignedBuffer<float> value, offset;
  AlignedBuffer<std::int32_t> first;
  std::vector<std::uint32_t> begin, end;  // [beams]
};

// Needs delay and doppler of the buffer. False if a node has no filter that holds the tolerance.
bool place_sets(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar, double tolerance,
                const NodeSpectra& spectra, NodeFilters& filters,
                std::span<const std::uint32_t> beam_offset, const EchoBuffer& echoes,
                const Workers& workers, std::vector<ShiftedSet>& sets);

void weigh_sets(const DopplerNodes& nodes, std::span<const std::uint32_t> beam_offset,
                const EchoBuffer& echoes, const Workers& workers, std::vector<ShiftedSet>& sets);

std::vector<EchoSet> echo_sets(std::vector<ShiftedSet>& sets);

}  // namespace ensonify
