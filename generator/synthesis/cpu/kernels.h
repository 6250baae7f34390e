// The inner loops of the fast path, compiled once per SimdLevel behind a table.
//
// The interface has plain arrays only. The files that fill the table are compiled for wider
// instructions than the other files. If they instantiated an inline function from a header, the
// linker could use this version of it in the whole program.
//
// The elements of an array are processed in groups of neighbors. The path from a point to a group
// is expanded about the group's middle: its length is exact there, and a polynomial of the
// element's number elsewhere.
//
//   GroupLine  PointArrays  PathArrays  GroupKernel  BeamElement  NodeSum   for arrays
//   PathFactors  EchoArrays  KernelPolynomial                               for any deposit
//   Kernels  kernels_of
#pragma once

#include <cstdint>

namespace ensonify {

constexpr int kGroupElements = 16;  // at most
constexpr int kPointChunk = 128;
constexpr int kBeamBlock = 64;  // samples
constexpr int kBeamTaps = 8;

// The place of a group, and scales per meter of path.
struct GroupLine {
  double middle_m;       // y of its middle
  double spacing_m;      // from element to element
  double turns_per_m;    // of the carrier, with the sign of the phases
  double points_per_m;   // of the time grid
  double first_element;  // from the middle to element 0, in elements: -(count - 1)/2
  int points, width;     // of the time grid and its kernel
};

// Points as seen from the origin.
struct PointArrays {
  const double* range_m;
  const double* along_m;   // y
  const double* turns;     // of the carrier at the origin
  const double* position;  // on the time grid, in grid points; any number
};

// The same points as seen from a group. For its element l, with x = l + first_element:
//   phase     turns 2^-32 + l slope 2^-32 + x^2 (bend[0] + x (bend[1] + x bend[2])), in turns
//   position  `first` and `offset` of EchoArrays, with x (shift[0] + x shift[1]) added to `offset`
struct PathArrays {
  std::int32_t turns[kPointChunk], slope[kPointChunk];
  float bend[3][kPointChunk];
  std::int32_t first[kPointChunk];
  float offset[kPointChunk], shift[2][kPointChunk];
};

// The spreading kernel as WidePolynomials of (offset + shift) / reach.
struct GroupKernel {
  const float* coefficient;  // [ceil(width / 2)][terms][even, odd]
  int width, terms;          // terms: 3 .. 8
  float per_reach;
};

// One element's record at twice its sampling rate, and its taps and weights in a beam.
struct BeamElement {
  const float* even;  // re at taps 0, 2, 4 .. of the block's first sample
  const float* odd;   // re at taps 1, 3, 5 ..
  std::int64_t to_im;
  const float* tap;  // [kBeamTaps]
  float weight_re, weight_im;
};

// The bins whose node weights are given by one polynomial, and its degree.
constexpr int kSteerBins = 64;
constexpr int kSteerTaps = 11;
constexpr int kSteerDegree = 4;

// The sum of a beam's nodes over a stretch of samples. Coefficients are polynomials of t = -1 .. 1
// over the stretch, [taps][degree + 1][re, im], constant term last.
struct NodeSum {
  const float* coefficient;
  int taps, degree;  // 0, 3 or 5
  const float* re;   // of the first tap; the other taps follow at distances of `stride`
  const float* im;
  std::int64_t stride;
};

enum class SimdLevel;

// A row of a deposit grid has `points` complex numbers, and as many as this before and after them,
// so that no kernel has to wrap around.
constexpr int kHalo = 16;
// The floats per node in one mixing tile, and the rows of a block of the packed matrix.
constexpr int kTile = 256;
constexpr int kRowBlock = 6;

// Draws of the amplitudes of one list of echoes that are deposited at once.
constexpr int kDraws = 8;

// What the paths of up to kPathChunk echoes do to their amplitudes.
constexpr int kPathChunk = 512;
struct PathFactors {
  float amount[kPathChunk], cosine[kPathChunk], sine[kPathChunk];
};

// Echoes that are ready for the deposit.
struct EchoArrays {
  float* value;         // re and im interleaved
  std::int32_t* first;  // the grid point at which the kernel begins
  float* offset;        // in [-1, 1): twice the distance from the kernel's edge to `first`, less 1
};

// The spreading kernel as polynomials in `offset`, one per point, with each coefficient twice (for
// re and im): [degree + 1][chunks][8], highest degree first.
struct KernelPolynomial {
  const float* coefficient;
  int degree;
  int chunks;  // of 4 points; at most 4
};

struct Kernels {
  // Circular complex normal numbers with E|xi|^2 = 1, equal to complex_normal(key, ping, hi:lo, 0)
  // to 3e-7.
  void (*draw_normals)(std::uint64_t key, std::uint32_t ping, const std::uint32_t* lo,
                       const std::uint32_t* hi, int count, float* re, float* im);
  // path = scale gain and e^(-i 2 pi frequency delay).
  void (*turn_paths)(double frequency_hz, float scale, const double* delay_s, const float* gain,
                     int count, PathFactors* path);
  // value[i stride], value[i stride + 1] = re and im of (re, im) path[i].
  void (*apply_paths)(const PathFactors* path, const float* re, const float* im, int count,
                      int stride, float* value);
  // Where the kernels of echoes begin. delay_s times `rate` is the delay in periods of the grid.
  void (*place)(double rate, int points, int width, const double* delay_s, int count,
                std::int32_t* first, float* offset);
  // rows[r][first ...] += weight[r] * value * kernel for echoes [begin, end). weight[r] is a pair
  // of weights, for re and im.
  void (*deposit)(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                  const KernelPolynomial* kernel, const float* weight, int row_count, float* rows,
                  std::int64_t stride);
  // The same for kDraws draws of the amplitudes at once, whose values are next to each other in
  // `echoes` and in the rows: rows[r][first ...][kDraws]. Each draw gets the bits that deposit
  // gives it. `width` points of the kernel are not zero.
  void (*deposit_draws)(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                        const KernelPolynomial* kernel, int width, const float* weight,
                        int row_count, float* rows, std::int64_t stride);
  // row[i] += weight[i % 2] * cells[i].
  void (*add_scaled)(const float* weight, const float* cells, int count, float* row);
  // Converts complex floats with halos to complex doubles without, and doubles back to two planes.
  void (*widen)(const float* row, int points, int halo, double* out);
  // The same for the row of kDraws draws. The spectrum of each begins `stride` doubles after that
  // of the draw before it.
  void (*widen_draws)(const float* row, int points, int halo, double* out, std::int64_t stride);
  void (*narrow)(const double* row, int count, float* re, float* im);
  // out = a f, and out += a f, for complex doubles.
  void (*multiply)(const double* a, const double* f, int count, double* out);
  void (*multiply_add)(const double* a, const double* f, int count, double* out);
  // y[row][kTile] = sum_k packed[row / kRowBlock][k][row % kRowBlock] x[k][kTile].
  void (*product)(const float* packed, int row_count, int depth, const float* x, float* y);
  // even[c] = x[c] + x[n-1-c] and odd[c] = x[c] - x[n-1-c] for c < n/2, and the inverse. The tile
  // of node c consists of `segments` pieces of kTile / segments floats, one from each of its
  // planes.
  void (*fold)(const float* planes, std::int64_t stride, int segments, int nodes, float* even,
               float* odd);
  void (*unfold)(const float* even, const float* odd, int nodes, float* x);
  // out[kTile] = sum_w weight[w] x[w][kTile].
  void (*combine)(const float* weight, int width, const float* x, float* out);
  // Store a tile as complex numbers (plus `added`, unless null), store it as powers, or add its
  // |.|^2 to powers.
  void (*store_complex)(const float* tile, const float* added, int count, float* out);
  void (*store_power)(const float* tile, int count, float* out);
  void (*add_square)(const float* tile, int count, float* out);
  // For arrays: the paths of up to kPointChunk points to a group of elements.
  void (*array_paths)(const GroupLine* line, const PointArrays* points, int count,
                      PathArrays* paths);
  // Deposits the echoes of a chunk on the grid of a group's elements,
  // [halo + points + halo][re, im][kGroupElements]. It writes all kGroupElements; only the values
  // of the group's own elements are valid.
  void (*array_deposit)(double first_element, const PathArrays* paths, const float* re,
                        const float* im, int count, const GroupKernel* kernel, float* grid);
  // Converts elements [first, first + count) of such a grid, at most 4, to complex doubles without
  // halos, [count][points].
  void (*widen_elements)(const float* grid, int points, int halo, int first, int count,
                         double* out);
  // (re, im) += weight e^(i phase) record for a group's elements and a block of samples, a multiple
  // of 16. Without paths (null), the weights are complex and contain the phase.
  void (*array_beam)(const BeamElement* elements, int count, double first_element,
                     const PathArrays* paths, int samples, float* re, float* im);
  // out[bin] = sum_tap weight_tap(t) rows[tap][bin] for complex numbers. weight: [kSteerTaps]
  // [kSteerDegree + 1], constant term last. t has each value twice, for re and im.
  void (*array_steer)(const double* rows, std::int64_t stride, const double* weight,
                      const double* t, int bins, double* out);
  // (re, im) += the sum of nodes, for a multiple of 16 samples.
  void (*array_nodes)(const NodeSum* sum, const float* t, int samples, float* re, float* im);
};

// The table of a level. The processor must support the level.
const Kernels& kernels_of(SimdLevel level);

}  // namespace ensonify
