// The inner loops of the fast path, compiled once per SimdLevel behind this table.
//
// Plain arrays only: the files that fill the table are compiled for wider instructions than the
// rest, and an inline function of a header in them could end up in the whole program.
#pragma once

#include <cstdint>

#include "synthesis/cpu/kernels_array.h"

namespace ensonify {

enum class SimdLevel;

// A row of a deposit grid holds `points` complex numbers with this many more before and behind
// them, so that no kernel has to wrap.
constexpr int kHalo = 16;
// Floats that one mixing tile holds of every node, and rows of a block of the packed matrix.
constexpr int kTile = 256;
constexpr int kRowBlock = 6;

// Echoes ready to be deposited.
struct EchoArrays {
  float* value;         // re and im by turns
  std::int32_t* first;  // grid point where the kernel begins
  float* offset;        // in [-1, 1): twice the distance from the kernel's edge to `first`, less 1
};

// The spreading kernel as polynomials in `offset`, one a point, each coefficient twice (for re and
// im): [degree + 1][chunks][8], highest degree first.
struct KernelPolynomial {
  const float* coefficient;
  int degree;
  int chunks;  // of 4 points; at most 4
};

struct Kernels {
  // Circular complex normals, E|xi|^2 = 1: those of complex_normal(key, ping, hi:lo, 0), to 3e-7.
  void (*draw_normals)(std::uint64_t key, std::uint32_t ping, const std::uint32_t* lo,
                       const std::uint32_t* hi, int count, float* re, float* im);
  // value = (re, im) scale gain e^(-i 2 pi frequency delay), re and im by turns.
  void (*apply_path)(double frequency_hz, float scale, const double* delay_s, const float* gain,
                     const float* re, const float* im, int count, float* value);
  // Where the kernels of echoes begin, delay_s times `rate` being in periods.
  void (*place)(double rate, int points, int width, const double* delay_s, int count,
                std::int32_t* first, float* offset);
  // rows[r][first ...] += weight[r] * value * kernel for echoes [begin, end); weight[r] is a pair,
  // for re and for im.
  void (*deposit)(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                  const KernelPolynomial* kernel, const float* weight, int row_count, float* rows,
                  std::int64_t stride);
  // row[i] += weight[i % 2] * cells[i].
  void (*add_scaled)(const float* weight, const float* cells, int count, float* row);
  // Complex floats with halos to complex doubles without, and back to two planes.
  void (*widen)(const float* row, int points, int halo, double* out);
  void (*narrow)(const double* row, int count, float* re, float* im);
  // out = a f, and out += a f, of complex doubles.
  void (*multiply)(const double* a, const double* f, int count, double* out);
  void (*multiply_add)(const double* a, const double* f, int count, double* out);
  // y[row][kTile] = sum_k packed[row / kRowBlock][k][row % kRowBlock] x[k][kTile].
  void (*product)(const float* packed, int row_count, int depth, const float* x, float* y);
  // even[c] = x[c] + x[n-1-c], odd[c] = the difference, for c < n/2; and back. Node c's tile is
  // `segments` pieces of kTile / segments floats, one from each of its planes.
  void (*fold)(const float* planes, std::int64_t stride, int segments, int nodes, float* even,
               float* odd);
  void (*unfold)(const float* even, const float* odd, int nodes, float* x);
  // out[kTile] = sum_w weight[w] x[w][kTile].
  void (*combine)(const float* weight, int width, const float* x, float* out);
  // Ends of a tile: to complex numbers (plus `added`, unless null), to powers, |.|^2 added.
  void (*store_complex)(const float* tile, const float* added, int count, float* out);
  void (*store_power)(const float* tile, int count, float* out);
  void (*add_square)(const float* tile, int count, float* out);
  // Arrays of elements: where a group of them hears up to kPointChunk points.
  void (*array_paths)(const GroupLine* line, const PointArrays* points, int count,
                      PathArrays* paths);
  // Echoes of a chunk onto the grid of a group's elements, [halo + points + halo][re, im]
  // [kGroupElements]; all elements are written, the group's own are right.
  void (*array_deposit)(double first_element, const PathArrays* paths, const float* re,
                        const float* im, int count, const GroupKernel* kernel, float* grid);
  // Elements [first, first + count) of such a grid, at most 4, to complex doubles without halos:
  // [count][points].
  void (*widen_elements)(const float* grid, int points, int halo, int first, int count,
                         double* out);
  // (re, im) += weight e^(i phase) record for a group's elements and a block of samples, a multiple
  // of 16; without paths the weights are complex and hold the phase.
  void (*array_beam)(const BeamElement* elements, int count, double first_element,
                     const PathArrays* paths, int samples, float* re, float* im);
  // out[bin] = sum_tap weight_tap(t) rows[tap][bin] of complex numbers; weight [kSteerTaps]
  // [kSteerDegree + 1], constant term last, t twice for each bin.
  void (*array_steer)(const double* rows, std::int64_t stride, const double* weight,
                      const double* t, int bins, double* out);
  // (re, im) += the sum, for a multiple of 16 samples.
  void (*array_nodes)(const NodeSum* sum, const float* t, int samples, float* re, float* im);
};

// The table of a level that this processor has.
const Kernels& kernels_of(SimdLevel level);

}  // namespace ensonify
