// What the inner loops over the elements of an array work on: plain arrays, as in kernels.h.
//
// Elements are taken in groups of neighbours. A group sees a point under a path that is expanded
// about the group's middle: its length is exact there, and a polynomial of the element's number
// beside it.
#pragma once

#include <cstdint>

namespace ensonify {

constexpr int kGroupElements = 16;  // at most
constexpr int kPointChunk = 128;
constexpr int kBeamBlock = 64;  // samples
constexpr int kBeamTaps = 8;

// A group's place, and what a metre is.
struct GroupLine {
  double middle_m;       // y of its middle
  double spacing_m;      // from element to element
  double turns_per_m;    // of the carrier, with the sign that phases get
  double points_per_m;   // of the time grid
  double first_element;  // from the middle to element 0, in elements: -(count - 1)/2
  int points, width;     // of the time grid and its kernel
};

// Points as the origin sees them.
struct PointArrays {
  const double* range_m;
  const double* along_m;   // y
  const double* turns;     // of the carrier at the origin
  const double* position;  // on the time grid, in grid points; any number
};

// The same as a group sees them. Element l of it, x = l + first_element:
//   phase     turns 2^-32 + l slope 2^-32 + x^2 (bend[0] + x (bend[1] + x bend[2])), in turns
//   position  `first`, `offset` as in EchoArrays, and later by x (shift[0] + x shift[1]) of offset
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

// One element's record, twice as dense as its samples, and what a beam does with it.
struct BeamElement {
  const float* even;  // re where taps 0, 2, 4 .. of the block's first sample lie
  const float* odd;   // and taps 1, 3, 5 ..
  std::int64_t to_im;
  const float* tap;  // [kBeamTaps]
  float weight_re, weight_im;
};

// Bins whose node weights are one polynomial, and its degree.
constexpr int kSteerBins = 64;
constexpr int kSteerTaps = 11;
constexpr int kSteerDegree = 4;

// What a beam makes of its nodes over a stretch of samples: coefficients are polynomials of
// t = -1 .. 1 over the stretch, [taps][degree + 1][re, im], constant term last.
struct NodeSum {
  const float* coefficient;
  int taps, degree;  // 0, 3 or 5
  const float* re;   // of the first tap; the others follow at `stride`
  const float* im;
  std::int64_t stride;
};

}  // namespace ensonify
