// The inner loops of the plain methods that `ensonify bench` measures against, and the one that
// finds the peak of the arithmetic; compiled once for each level of vector instructions.
//
//   PhasorSum   scatterers of one sector, for the sums over scatterers at every bin
//   ConjugateProduct  their sums times the pulse
//   ExactSum    sums in double precision
//   MixPanel    a few columns of the full product over beams
//   KernelTable the loops of one level
//   supported_kernels  best_kernels
//
// Only plain types stand here: the sources that include this are compiled for processors that the
// program may not run on, and must not leave code in functions that others share.
#pragma once

#include <cstdint>

namespace ensonify {

// Turns are fractions of 2^64, so that reducing them is free and exact.
struct PhasorSum {
  const std::uint64_t* start;  // turns at bin 0
  const std::uint64_t* step;   // turns from bin to bin
  const float* magnitude;
  int count;
  int bins;
  float* re;         // [padded_bins(bins)], written: sum magnitude cos(2 pi (start + m step))
  float* im;         // the same with sin
  float* workspace;  // [2 count]
};

// out[m] = (re - i im)(pulse_re + i pulse_im), m < count, as complex numbers.
struct ConjugateProduct {
  const float *re, *im;
  const float *pulse_re, *pulse_im;
  int count;
  float* out;
};

struct ExactSum {
  const double* start_re;  // phasors at bin 0
  const double* start_im;
  const double* step_re;  // factors from bin to bin
  const double* step_im;
  int count;
  int bins;
  double* re;  // [padded_bins(bins)], zero before
  double* im;
};

// out[j][c] = sum_i weight_ij in[i][c] for the columns [first, first + mix_columns).
struct MixPanel {
  const float* weights;  // [beams / mix_rows, rounded up][i = 0 .. beams-1][mix_rows]
  const float* in;       // [beams][stride]
  float* out;            // [beams][stride]
  int beams;
  int stride;
  int first;
  float* workspace;  // [beams x mix_columns]
};

struct KernelTable {
  const char* level;
  void (*direct)(const PhasorSum&);      // sine and cosine for each scatterer and bin
  void (*recurrence)(const PhasorSum&);  // one complex rotation for each scatterer and bin
  void (*shape)(const ConjugateProduct&);
  void (*exact)(const ExactSum&);
  void (*mix)(const MixPanel&);
  float (*multiply_adds)(long rounds, float seed);
  int mix_rows, mix_columns;
  int flops_per_round;  // of multiply_adds
};

inline constexpr int kBinBlock = 128;
constexpr int padded_bins(int bins) { return (bins + kBinBlock - 1) / kBinBlock * kBinBlock; }

extern const KernelTable kSse4Kernels, kAvx2Kernels, kAvx512Kernels;

// Those that this processor runs, slowest first; at least one.
struct KernelList {
  const KernelTable* table[3];
  int count;
};
KernelList supported_kernels();
const KernelTable& best_kernels();

}  // namespace ensonify
