// The work of one thread of a device from beam cells, called sectors in the code, over the nodes of
// cpu/beam_nodes.h to beams. Functors are as in beam_kernels.h.
//
//   SpreadSeries   grids of sectors -> grids of nodes; SpreadPowers
//   MixSeries      records of nodes -> beams, with noise; MixPowers
#pragma once

#include <cstdint>

#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// The sectors that reach the nodes 2 r and 2 r + 1: cells [offset[r], offset[r + 1]).
struct NodeReach {
  const SectorRecord* cells;
  const std::uint32_t* offset;
  int nodes;
};

// Writes out [pings][nodes][length] from grids or cells [pings][sectors][length]. The count is
// pings times nodes / 2 times length.
struct SpreadSeries {
  const Complex32* grid;
  NodeReach reach;
  int sectors, length;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t n = i % length, row = i / length, pairs = reach.nodes / 2;
    const Complex32* own = grid + row / pairs * sectors * length + n;
    Complex32 even{0, 0}, odd{0, 0};
    for (std::uint32_t c = reach.offset[row % pairs]; c < reach.offset[row % pairs + 1]; ++c) {
      const SectorRecord cell = reach.cells[c];
      const Complex32 z = own[std::int64_t{cell.sector} * length];
      even += cell.even * z;
      odd += cell.odd * z;
    }
    out[2 * row * length + n] = even;
    out[(2 * row + 1) * length + n] = odd;
  }
};

// Writes out [pings][nodes / 2][length], two nodes per row, from [pings][ceil(sectors /
// 2)][length], two sectors per row.
struct SpreadPowers {
  const Complex32* grid;
  NodeReach reach;
  int sectors, length;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t n = i % length, row = i / length, pairs = reach.nodes / 2;
    const Complex32* own = grid + row / pairs * ((sectors + 1) / 2) * length + n;
    Complex32 sum{0, 0};
    for (std::uint32_t c = reach.offset[row % pairs]; c < reach.offset[row % pairs + 1]; ++c) {
      const SectorRecord cell = reach.cells[c];
      const Complex32 both = own[std::int64_t{cell.sector / 2} * length];
      const float power = cell.sector % 2 == 0 ? both.re : both.im;
      sum += Complex32{cell.even * power, cell.odd * power};
    }
    out[i] = sum;
  }
};

// Writes beams [pings][beams][samples] from records [pings][nodes][transform]. weight: [blocks of
// beams][nodes]. The count is pings times blocks times samples.
struct MixSeries {
  const Complex32* record;
  const BatchPing* pings;
  const BeamWeights* weight;
  int nodes, beams, samples, transform;
  bool adds_noise;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t n = i % samples, blocks = (beams + kBeamsAThread - 1) / kBeamsAThread;
    const std::int64_t block = i / samples % blocks, ping = i / samples / blocks;
    const Complex32* own = record + ping * nodes * transform + n;
    Complex32 sum[kBeamsAThread] = {};
    for (int c = 0; c < nodes; ++c) {
      const BeamWeights w = weight[block * nodes + c];
      const Complex32 z = own[std::int64_t{c} * transform];
      ENSONIFY_UNROLL
      for (int b = 0; b < kBeamsAThread; ++b) sum[b] += w.of_beam[b] * z;
    }
    ENSONIFY_UNROLL
    for (int b = 0; b < kBeamsAThread; ++b) {
      const int beam = static_cast<int>(block) * kBeamsAThread + b;
      if (beam >= beams) continue;
      Complex32 p = sum[b];
      if (adds_noise && pings[ping].noise_rms != 0) {
        const BatchPing& noise = pings[ping];
        p += narrow(cell_draw(noise.noise_key, noise.noise_ping, beam, static_cast<int>(n),
                              noise.noise_rms));
      }
      out[(ping * beams + beam) * samples + n] = p;
    }
  }
};

// Writes samples [first, first + count) of powers [pings][beams][samples] from records
// [pings][nodes / 2][transform], two nodes per row. Adds |means|^2, [pings][beams][samples], unless
// null. The weights are those of powers. The count is pings times blocks of beams times `count`.
struct MixPowers {
  const Complex32* record;
  const Complex32* means;
  const BeamWeights* weight;
  int nodes, beams, samples, transform, first, count;
  float* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t n = first + i % count, blocks = (beams + kBeamsAThread - 1) / kBeamsAThread;
    const std::int64_t block = i / count % blocks, ping = i / count / blocks;
    const Complex32* own = record + ping * (nodes / 2) * transform + n;
    float sum[kBeamsAThread] = {};
    for (int c = 0; c < nodes; c += 2) {
      const BeamWeights even = weight[block * nodes + c], odd = weight[block * nodes + c + 1];
      const Complex32 z = own[std::int64_t{c / 2} * transform];
      ENSONIFY_UNROLL
      for (int b = 0; b < kBeamsAThread; ++b) {
        sum[b] += even.of_beam[b] * z.re + odd.of_beam[b] * z.im;
      }
    }
    ENSONIFY_UNROLL
    for (int b = 0; b < kBeamsAThread; ++b) {
      const int beam = static_cast<int>(block) * kBeamsAThread + b;
      if (beam >= beams) continue;
      const std::int64_t at = (ping * beams + beam) * samples + n;
      out[at] = finished_power(sum[b], means, at);
    }
  }
};

}  // namespace ensonify
