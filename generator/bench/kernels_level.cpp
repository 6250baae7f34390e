// Compiled once for each level, with ENSONIFY_LEVEL, ENSONIFY_TABLE, ENSONIFY_LANES (floats in a
// vector), ENSONIFY_MIX_ROWS and ENSONIFY_SUM_VECTORS (what its registers hold) defined by CMake.
#include "bench/kernels.h"

namespace ensonify {
namespace {

constexpr int kLanes = ENSONIFY_LANES;
constexpr int kWideLanes = kLanes / 2;
constexpr int kSumVectors = ENSONIFY_SUM_VECTORS;
constexpr int kMixRows = ENSONIFY_MIX_ROWS;
constexpr int kMixVectors = 3;
constexpr int kChains = 12;

typedef float Floats __attribute__((vector_size(kLanes * 4)));
typedef std::int32_t Ints __attribute__((vector_size(kLanes * 4)));
typedef std::uint32_t Words __attribute__((vector_size(kLanes * 4)));
typedef double Doubles __attribute__((vector_size(kWideLanes * 8)));

static_assert(kBinBlock % (kSumVectors * kLanes) == 0 && kBinBlock % kWideLanes == 0);

template <class Vector, class Value>
inline Vector load(const Value* from) {
  Vector v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

template <class Vector, class Value>
inline void store(Value* to, Vector v) {
  __builtin_memcpy(to, &v, sizeof v);
}

inline std::uint32_t high_word(std::uint64_t turns) {
  return static_cast<std::uint32_t>(turns >> 32);
}

// sin(2 pi x) for |x| <= 1/4, within 6e-7.
inline Floats quarter_sine(Floats x) {
  const Floats y = x * x;
  return x * (6.28316395f + y * (-41.3371304f + y * (81.3403861f + y * -70.989933f)));
}

// Cosine and sine of turns in fractions of 2^32.
inline void cosine_and_sine(Words turns, Floats& cosine, Floats& sine) {
  const Floats t =
      __builtin_convertvector(__builtin_bit_cast(Ints, turns), Floats) * 2.3283064365e-10f;
  const Ints bits = __builtin_bit_cast(Ints, t);
  const Ints sign = bits & INT32_MIN;
  const Floats from_quarter = 0.25f - __builtin_bit_cast(Floats, bits ^ sign);
  const Ints unsigned_bits = __builtin_bit_cast(Ints, from_quarter) & INT32_MAX;
  const Floats folded = 0.25f - __builtin_bit_cast(Floats, unsigned_bits);
  cosine = quarter_sine(from_quarter);
  sine = __builtin_bit_cast(Floats, __builtin_bit_cast(Ints, quarter_sine(folded)) ^ sign);
}

inline Words lane_numbers() {
  Words lane;
  for (int i = 0; i < kLanes; ++i) lane[i] = static_cast<std::uint32_t>(i);
  return lane;
}

inline void store_block(const PhasorSum& sum, int first, const Floats* re, const Floats* im) {
#pragma GCC unroll 8
  for (int v = 0; v < kSumVectors; ++v) {
    store(sum.re + first + v * kLanes, re[v]);
    store(sum.im + first + v * kLanes, im[v]);
  }
}

void direct(const PhasorSum& sum) {
  const Words lane = lane_numbers();
  for (int first = 0; first < sum.bins; first += kSumVectors * kLanes) {
    Floats re[kSumVectors] = {}, im[kSumVectors] = {};
    for (int i = 0; i < sum.count; ++i) {
      const std::uint64_t at = sum.start[i] + static_cast<std::uint64_t>(first) * sum.step[i];
      const std::uint32_t step = high_word(sum.step[i]);
      Words turns = high_word(at) + lane * step;
#pragma GCC unroll 8
      for (int v = 0; v < kSumVectors; ++v) {
        Floats cosine, sine;
        cosine_and_sine(turns, cosine, sine);
        re[v] += sum.magnitude[i] * cosine;
        im[v] += sum.magnitude[i] * sine;
        turns += step * kLanes;
      }
    }
    store_block(sum, first, re, im);
  }
}

// Factors that turn every phasor by one vector of bins.
void rotations(const PhasorSum& sum, float* re, float* im) {
  for (int i = 0; i < sum.count; i += kLanes) {
    const int n = sum.count - i < kLanes ? sum.count - i : kLanes;
    Words turns = {};
    for (int l = 0; l < n; ++l) turns[l] = high_word(sum.step[i + l] * kLanes);
    Floats cosine, sine;
    cosine_and_sine(turns, cosine, sine);
    for (int l = 0; l < n; ++l) {
      re[i + l] = cosine[l];
      im[i + l] = sine[l];
    }
  }
}

// Every lane is a chain of its own; each block of bins starts anew from a sine and cosine, so that
// rounding does not pile up.
void recurrence(const PhasorSum& sum) {
  const Words lane = lane_numbers();
  float* turn_re = sum.workspace;
  float* turn_im = sum.workspace + sum.count;
  rotations(sum, turn_re, turn_im);
  for (int first = 0; first < sum.bins; first += kSumVectors * kLanes) {
    Floats re[kSumVectors] = {}, im[kSumVectors] = {};
    for (int i = 0; i < sum.count; ++i) {
      const std::uint64_t at = sum.start[i] + static_cast<std::uint64_t>(first) * sum.step[i];
      Floats z_re, z_im;
      cosine_and_sine(high_word(at) + lane * high_word(sum.step[i]), z_re, z_im);
      z_re *= sum.magnitude[i];
      z_im *= sum.magnitude[i];
#pragma GCC unroll 8
      for (int v = 0; v < kSumVectors; ++v) {
        re[v] += z_re;
        im[v] += z_im;
        const Floats turned = z_re * turn_re[i] - z_im * turn_im[i];
        z_im = z_re * turn_im[i] + z_im * turn_re[i];
        z_re = turned;
      }
    }
    store_block(sum, first, re, im);
  }
}

void shape(const ConjugateProduct& product) {
  const float* __restrict re = product.re;
  const float* __restrict im = product.im;
  const float* __restrict pulse_re = product.pulse_re;
  const float* __restrict pulse_im = product.pulse_im;
  float* __restrict out = product.out;
  for (int m = 0; m < product.count; ++m) {
    out[2 * m] = re[m] * pulse_re[m] + im[m] * pulse_im[m];
    out[2 * m + 1] = re[m] * pulse_im[m] - im[m] * pulse_re[m];
  }
}

void exact(const ExactSum& sum) {
  for (int i = 0; i < sum.count; ++i) {
    Doubles z_re, z_im;
    double re = sum.start_re[i], im = sum.start_im[i];
    double power_re = 1, power_im = 0;
    for (int l = 0; l < kWideLanes; ++l) {
      z_re[l] = re * power_re - im * power_im;
      z_im[l] = re * power_im + im * power_re;
      const double next = power_re * sum.step_re[i] - power_im * sum.step_im[i];
      power_im = power_re * sum.step_im[i] + power_im * sum.step_re[i];
      power_re = next;
    }
    for (int m = 0; m < sum.bins; m += kWideLanes) {
      store(sum.re + m, load<Doubles>(sum.re + m) + z_re);
      store(sum.im + m, load<Doubles>(sum.im + m) + z_im);
      const Doubles turned = z_re * power_re - z_im * power_im;
      z_im = z_re * power_im + z_im * power_re;
      z_re = turned;
    }
  }
}

void mix(const MixPanel& panel) {
  constexpr int kColumns = kMixVectors * kLanes;
  for (int i = 0; i < panel.beams; ++i) {
    const float* row = panel.in + static_cast<long>(i) * panel.stride + panel.first;
    __builtin_memcpy(panel.workspace + i * kColumns, row, kColumns * sizeof(float));
  }
  for (int block = 0; block < panel.beams; block += kMixRows) {
    Floats sum[kMixRows][kMixVectors] = {};
    const float* weights = panel.weights + static_cast<long>(block) * panel.beams;
    for (int i = 0; i < panel.beams; ++i) {
      Floats x[kMixVectors];
#pragma GCC unroll 8
      for (int c = 0; c < kMixVectors; ++c) {
        x[c] = load<Floats>(panel.workspace + i * kColumns + c * kLanes);
      }
#pragma GCC unroll 8
      for (int r = 0; r < kMixRows; ++r) {
#pragma GCC unroll 8
        for (int c = 0; c < kMixVectors; ++c) sum[r][c] += weights[i * kMixRows + r] * x[c];
      }
    }
    for (int r = 0; r < kMixRows && block + r < panel.beams; ++r) {
      float* row = panel.out + static_cast<long>(block + r) * panel.stride + panel.first;
      for (int c = 0; c < kMixVectors; ++c) store(row + c * kLanes, sum[r][c]);
    }
  }
}

// Independent chains of multiply-adds, enough of them to hide their latency.
float multiply_adds(long rounds, float seed) {
  Floats chain[kChains];
  for (int i = 0; i < kChains; ++i) chain[i] = Floats{} + (seed + static_cast<float>(i));
  const Floats factor = Floats{} + 0.999f * seed, term = Floats{} + 0.001f;
  for (long round = 0; round < rounds; ++round) {
#pragma GCC unroll 12
    for (int i = 0; i < kChains; ++i) chain[i] = chain[i] * factor + term;
  }
  float sum = 0;
  for (int i = 0; i < kChains; ++i) sum += chain[i][0];
  return sum;
}

}  // namespace

const KernelTable ENSONIFY_TABLE = {ENSONIFY_LEVEL,
                                    direct,
                                    recurrence,
                                    shape,
                                    exact,
                                    mix,
                                    multiply_adds,
                                    kMixRows,
                                    kMixVectors* kLanes,
                                    2 * kChains* kLanes};

}  // namespace ensonify
