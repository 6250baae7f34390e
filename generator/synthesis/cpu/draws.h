// The fast path for several pings of one scene, which differ in random numbers alone. What does not
// depend on those is computed once for kDraws pings: the places of echoes, their phases and
// kernels. Values of the pings are next to each other, so that one instruction deposits an echo of
// several pings. Each ping gets the bits that it would get alone, whatever the others of its batch
// are.
//
//   DrawScratch      the memory of a batch
//   transform_draws  echoes -> records of nodes, as transform_nodes for each ping
#pragma once

#include <cstdint>
#include <span>

#include "synthesis/cpu/node_sums.h"

namespace ensonify {

struct DrawScratch {
  EchoBuffer echoes;
  AlignedBuffer<float> planes;  // [kDraws][2 rows][plane_stride]

  const float* planes_of(const NodePlan& plan, int draw) const {
    return planes.data() + 2 * plan.rows * plan.plane_stride() * draw;
  }
};

// `echoes` has kDraws draws, of which some may be unused. They are not const, as kernels take plain
// arrays.
void transform_draws(const NodePlan& plan, const Kernels& kernels, EchoBuffer& echoes,
                     std::span<const std::uint32_t> beam_offset, Pool<NodeScratch>& pool,
                     const Workers& workers, AlignedBuffer<float>& planes);

}  // namespace ensonify
