// The table of one level. A separate source file for each level includes this file and defines
// ENSONIFY_LEVEL (a namespace) and ENSONIFY_VECTOR_BYTES.
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "synthesis/cpu/kernels.h"

namespace ensonify::ENSONIFY_LEVEL {
namespace {

constexpr int kLanes = ENSONIFY_VECTOR_BYTES / 4;
typedef float Vector __attribute__((vector_size(ENSONIFY_VECTOR_BYTES)));
// The same vector without alignment.
typedef float LooseVector
    __attribute__((vector_size(ENSONIFY_VECTOR_BYTES), aligned(4), may_alias));

inline Vector load(const float* p) { return *reinterpret_cast<const LooseVector*>(p); }
inline void store(float* p, Vector v) { *reinterpret_cast<LooseVector*>(p) = v; }

// Random draws and phases: scalar code in loops that the compiler vectorizes.

typedef std::uint64_t Words __attribute__((vector_size(ENSONIFY_VECTOR_BYTES)));
typedef std::uint32_t HalfWords
    __attribute__((vector_size(ENSONIFY_VECTOR_BYTES / 2), aligned(4), may_alias));
constexpr int kWords = ENSONIFY_VECTOR_BYTES / 8;

// Products of the lower halves of the words. The compiler would multiply all 64 bits.
inline Words multiply_low(Words a, Words b) {
#if defined(__AVX512F__)
  // Without a mask, gcc 12 prints a warning about its own header.
  return reinterpret_cast<Words>(_mm512_maskz_mul_epu32(0xFF, reinterpret_cast<__m512i>(a),
                                                        reinterpret_cast<__m512i>(b)));
#elif defined(__AVX2__)
  return reinterpret_cast<Words>(
      _mm256_mul_epu32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
#elif defined(__SSE2__)
  return reinterpret_cast<Words>(
      _mm_mul_epu32(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
#else
  return (a & 0xFFFFFFFFu) * b;
#endif
}

// The first two words of Philox 4x32-10 of core/random.h with counters (ping, lo, hi, 0). A lane of
// 64 bits has one word in its lower half. Its upper half is arbitrary.
inline void philox(std::uint64_t key, std::uint32_t ping, const std::uint32_t* lo,
                   const std::uint32_t* hi, std::uint32_t* first, std::uint32_t* second) {
  std::uint32_t k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  Words c0 = Words{} + ping, c3 = {};
  Words c1 = __builtin_convertvector(*reinterpret_cast<const HalfWords*>(lo), Words);
  Words c2 = __builtin_convertvector(*reinterpret_cast<const HalfWords*>(hi), Words);
  const Words m0 = Words{} + 0xD2511F53u, m1 = Words{} + 0xCD9E8D57u;
#pragma GCC unroll 10
  for (int round = 0; round < 10; ++round) {
    const Words p0 = multiply_low(c0, m0), p1 = multiply_low(c2, m1);
    c0 = (p1 >> 32) ^ c1 ^ (Words{} + k0);
    c2 = (p0 >> 32) ^ c3 ^ (Words{} + k1);
    c1 = p1;
    c3 = p0;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  *reinterpret_cast<HalfWords*>(first) = __builtin_convertvector(c0, HalfWords);
  *reinterpret_cast<HalfWords*>(second) = __builtin_convertvector(c1, HalfWords);
}

// -log((w + 1/2) / 2^32). The polynomial is that of Cephes' logf, on [sqrt(1/2), sqrt(2)).
inline float minus_log(std::uint32_t w) {
  const std::uint32_t v = ~w;
  // Near 1, the distance to 1 comes from the integer, because a float has not enough digits for it.
  const bool near_one = v < 0x4AFB0CCDu;
  const float whole = static_cast<float>(static_cast<std::int32_t>(w >> 16)) * 65536.0f +
                      (static_cast<float>(static_cast<std::int32_t>(w & 0xFFFFu)) + 0.5f);
  const std::int32_t bits = __builtin_bit_cast(std::int32_t, whole);
  const std::int32_t exponent = (bits - 0x3F3504F3) >> 23;
  const float mantissa = __builtin_bit_cast(float, bits - exponent * (1 << 23));
  const float below =
      (static_cast<float>(static_cast<std::int32_t>(v & 0x7FFFFFFFu)) + 0.5f) * -0x1p-32f;
  const float x = near_one ? below : mantissa - 1.0f;
  const float e = near_one ? 0.0f : static_cast<float>(exponent - 32);
  float y = 7.0376836292e-2f;
  y = y * x - 1.1514610310e-1f;
  y = y * x + 1.1676998740e-1f;
  y = y * x - 1.2420140846e-1f;
  y = y * x + 1.4249322787e-1f;
  y = y * x - 1.6668057665e-1f;
  y = y * x + 2.0000714765e-1f;
  y = y * x - 2.4999993993e-1f;
  y = y * x + 3.3333331174e-1f;
  y = y * x * x * x;
  y += e * -2.12194440e-4f;
  y -= 0.5f * x * x;
  return -((x + y) + e * 0.693359375f);
}

// Sine and cosine of quadrant * pi/2 + x, |x| <= pi/4 (Cephes).
inline void sine_cosine(std::int32_t quadrant, float x, float* sine, float* cosine) {
  const float z = x * x;
  const float s =
      ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
  const float c =
      ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z -
      0.5f * z + 1.0f;
  const bool swap = (quadrant & 1) != 0;
  const float u = swap ? c : s, w = swap ? s : c;
  *sine = (quadrant & 2) != 0 ? -u : u;
  *cosine = ((quadrant + 1) & 2) != 0 ? -w : w;
}

void draw_normals(std::uint64_t key, std::uint32_t ping, const std::uint32_t* lo,
                  const std::uint32_t* hi, int count, float* __restrict re,
                  float* __restrict im) {
  constexpr int kBlock = 64;
  alignas(64) std::uint32_t words[2][kBlock] = {}, items[2][kBlock] = {};
  alignas(64) float part[2][kBlock];
  for (int at = 0; at < count; at += kBlock) {
    const int size = count - at < kBlock ? count - at : kBlock;
    const bool whole = size == kBlock;
    for (int i = 0; !whole && i < size; ++i) {
      items[0][i] = lo[at + i];
      items[1][i] = hi[at + i];
    }
    const std::uint32_t* low = whole ? lo + at : items[0];
    const std::uint32_t* high = whole ? hi + at : items[1];
    for (int i = 0; i < size; i += kWords) {
      philox(key, ping, low + i, high + i, words[0] + i, words[1] + i);
    }
    for (int i = 0; i < kBlock; ++i) {
      const float radius = __builtin_sqrtf(minus_log(words[0][i]));
      const std::uint32_t w = words[1][i];
      const std::uint32_t quadrant = (w + 0x20000000u) >> 30;
      const std::int32_t rest = static_cast<std::int32_t>(w - (quadrant << 30));
      const float angle = (static_cast<float>(rest) + 0.5f) * 1.4629180792671596e-9f;  // 2 pi / 2^32
      float sine, cosine;
      sine_cosine(static_cast<std::int32_t>(quadrant), angle, &sine, &cosine);
      part[0][i] = radius * cosine;
      part[1][i] = radius * sine;
    }
    for (int i = 0; i < size; ++i) {
      re[at + i] = part[0][i];
      im[at + i] = part[1][i];
    }
  }
}

void turn_paths(double frequency_hz, float scale, const double* __restrict delay_s,
                const float* __restrict gain, int count, PathFactors* __restrict path) {
  for (int i = 0; i < count; ++i) {
    // There may be 1e5 turns, which need double precision. The rest of a quarter turn fits a float.
    const double quarters = -4.0 * (frequency_hz * delay_s[i]);
    const double whole = __builtin_rint(quarters);
    const double period = whole - 4.0 * __builtin_floor(whole * 0.25);
    float sine, cosine;
    sine_cosine(static_cast<std::int32_t>(period),
                static_cast<float>((quarters - whole) * 1.5707963267948966), &sine, &cosine);
    path->amount[i] = scale * gain[i];
    path->cosine[i] = cosine;
    path->sine[i] = sine;
  }
}

void apply_block(const PathFactors* __restrict path, int first, const float* __restrict re,
                 const float* __restrict im, int count, float* __restrict value) {
  for (int i = 0; i < count; ++i) {
    const float a = path->amount[first + i];
    const float cosine = path->cosine[first + i], sine = path->sine[first + i];
    const float x = a * re[first + i], y = a * im[first + i];
    value[2 * i] = x * cosine - y * sine;
    value[2 * i + 1] = x * sine + y * cosine;
  }
}

void apply_paths(const PathFactors* path, const float* re, const float* im, int count, int stride,
                 float* value) {
  if (stride == 2) {
    apply_block(path, 0, re, im, count, value);
    return;
  }
  constexpr int kBlock = 64;
  alignas(64) float block[2 * kBlock];
  for (int at = 0; at < count; at += kBlock) {
    const int size = count - at < kBlock ? count - at : kBlock;
    apply_block(path, at, re, im, size, block);
    for (int i = 0; i < size; ++i) {
      float* out = value + static_cast<std::int64_t>(at + i) * stride;
      __builtin_memcpy(out, block + 2 * i, 2 * sizeof(float));
    }
  }
}

void place(double rate, int points, int width, const double* __restrict delay_s, int count,
           std::int32_t* __restrict first, float* __restrict offset) {
  for (int i = 0; i < count; ++i) {
    const double x = rate * delay_s[i];
    const double edge = (x - __builtin_floor(x)) * points - 0.5 * width;
    const double begin = __builtin_ceil(edge);
    first[i] = static_cast<std::int32_t>(begin);
    offset[i] = static_cast<float>(2.0 * (begin - edge) - 1.0);
  }
}

// Deposit on the time grid, and conversions before and after transforms.

// At most 8 floats. Wider vectors cross a cache line with every access and are not faster.
constexpr int kSpreadLanes = kLanes < 8 ? kLanes : 8;
typedef float SpreadVector __attribute__((vector_size(4 * kSpreadLanes), aligned(4), may_alias));

// Repeats one complex number in all pairs of lanes.
inline SpreadVector pairs(const float* p) {
  typedef double Pair __attribute__((may_alias, aligned(4)));
  typedef double PairVector __attribute__((vector_size(4 * kSpreadLanes)));
  const double pair = *reinterpret_cast<const Pair*>(p);
#if ENSONIFY_VECTOR_BYTES >= 32
  const PairVector v = {pair, pair, pair, pair};
#else
  const PairVector v = {pair, pair};
#endif
  return reinterpret_cast<SpreadVector>(v);
}

template <int kChunks>
inline void deposit_chunks(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                           const KernelPolynomial* kernel, const float* weight, int row_count,
                           float* rows, std::int64_t stride) {
  constexpr int kVectors = kChunks * 8 / kSpreadLanes;
  const int degree = kernel->degree;
  const auto at = [](const float* p, int v) {
    return *reinterpret_cast<const SpreadVector*>(p + v * kSpreadLanes);
  };
  for (std::int64_t i = begin; i < end; ++i) {
    const SpreadVector value = pairs(echoes->value + 2 * i);
    const float t = echoes->offset[i];
    const float* c = kernel->coefficient;
    SpreadVector sum[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[v] = at(c, v);
    for (int d = 0; d < degree; ++d) {
      c += kVectors * kSpreadLanes;
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) sum[v] = sum[v] * t + at(c, v);
    }
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[v] *= value;
    float* row = rows + 2 * (echoes->first[i] + kHalo);
    for (int r = 0; r < row_count; ++r, row += stride) {
      const SpreadVector w = pairs(weight + 2 * r);
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) {
        *reinterpret_cast<SpreadVector*>(row + v * kSpreadLanes) = at(row, v) + w * sum[v];
      }
    }
  }
}

void deposit(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
             const KernelPolynomial* kernel, const float* weight, int row_count, float* rows,
             std::int64_t stride) {
  const auto run = kernel->chunks == 1   ? deposit_chunks<1>
                   : kernel->chunks == 2 ? deposit_chunks<2>
                   : kernel->chunks == 3 ? deposit_chunks<3>
                                         : deposit_chunks<4>;
  run(echoes, begin, end, kernel, weight, row_count, rows, stride);
}

// The points of an echo's kernel.
inline void kernel_points(const KernelPolynomial* kernel, float t, float* __restrict point) {
  const int floats = 8 * kernel->chunks;
  for (int v = 0; v < floats; v += kSpreadLanes) {
    const float* c = kernel->coefficient + v;
    SpreadVector sum = *reinterpret_cast<const SpreadVector*>(c);
    for (int d = 0; d < kernel->degree; ++d) {
      c += floats;
      sum = sum * t + *reinterpret_cast<const SpreadVector*>(c);
    }
    *reinterpret_cast<SpreadVector*>(point + v) = sum;
  }
}

void deposit_draws(const EchoArrays* echoes, std::int64_t begin, std::int64_t end,
                   const KernelPolynomial* kernel, int width, const float* weight, int row_count,
                   float* rows, std::int64_t stride) {
  constexpr int kFloats = 2 * kDraws, kVectors = kFloats / kLanes;
  alignas(64) float point[32];
  for (std::int64_t i = begin; i < end; ++i) {
    kernel_points(kernel, echoes->offset[i], point);
    const float* value = echoes->value + i * kFloats;
    float* first = rows + std::int64_t{kFloats} * (echoes->first[i] + kHalo);
    for (int l = 0; l < width; ++l, first += kFloats) {
      Vector spread[kVectors];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) spread[v] = load(value + v * kLanes) * point[2 * l];
      float* at = first;
      for (int r = 0; r < row_count; ++r, at += stride) {
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v) {
          store(at + v * kLanes, load(at + v * kLanes) + weight[2 * r] * spread[v]);
        }
      }
    }
  }
}

void add_scaled(const float* __restrict weight, const float* __restrict cells, int count,
                float* __restrict row) {
  const float even = weight[0], odd = weight[1];
  for (int i = 0; i < count; i += 2) {
    row[i] += even * cells[i];
    row[i + 1] += odd * cells[i + 1];
  }
}

void widen(const float* __restrict row, int points, int halo, double* __restrict out) {
  const float* inner = row + 2 * halo;
  for (int i = 0; i < 2 * points; ++i) out[i] = static_cast<double>(inner[i]);
  for (int i = 0; i < 2 * halo; ++i) {
    out[2 * (points - halo) + i] += static_cast<double>(row[i]);
    out[i] += static_cast<double>(inner[2 * points + i]);
  }
}

// Writes, or adds, the pairs of one point of all draws.
template <bool kAdds>
inline void widen_point(const float* __restrict row, double* __restrict out, std::int64_t stride) {
  for (int d = 0; d < kDraws; ++d) {
    for (int part = 0; part < 2; ++part) {
      const double value = static_cast<double>(row[2 * d + part]);
      double* at = out + d * stride + part;
      *at = kAdds ? *at + value : value;
    }
  }
}

void widen_draws(const float* row, int points, int halo, double* out, std::int64_t stride) {
  constexpr int kFloats = 2 * kDraws;
  const float* inner = row + kFloats * halo;
  for (int i = 0; i < points; ++i) {
    widen_point<false>(inner + std::int64_t{kFloats} * i, out + 2 * i, stride);
  }
  for (int i = 0; i < halo; ++i) {
    widen_point<true>(row + std::int64_t{kFloats} * i, out + 2 * (points - halo + i), stride);
    widen_point<true>(inner + std::int64_t{kFloats} * (points + i), out + 2 * i, stride);
  }
}

void narrow(const double* __restrict row, int count, float* __restrict re, float* __restrict im) {
  for (int i = 0; i < count; ++i) {
    re[i] = static_cast<float>(row[2 * i]);
    im[i] = static_cast<float>(row[2 * i + 1]);
  }
}

void multiply(const double* __restrict a, const double* __restrict f, int count,
              double* __restrict out) {
  for (int i = 0; i < count; ++i) {
    out[2 * i] = a[2 * i] * f[2 * i] - a[2 * i + 1] * f[2 * i + 1];
    out[2 * i + 1] = a[2 * i] * f[2 * i + 1] + a[2 * i + 1] * f[2 * i];
  }
}

void multiply_add(const double* __restrict a, const double* __restrict f, int count,
                  double* __restrict out) {
  for (int i = 0; i < count; ++i) {
    out[2 * i] += a[2 * i] * f[2 * i] - a[2 * i + 1] * f[2 * i + 1];
    out[2 * i + 1] += a[2 * i] * f[2 * i + 1] + a[2 * i + 1] * f[2 * i];
  }
}

// Products over beams, one tile of time after another, and functions that store the results.

// With 32 registers, a block of 6 rows has 4 vectors of columns; with 16 registers, 2.
constexpr int kColumns = ENSONIFY_VECTOR_BYTES == 64 ? 4 : 2;

void product(const float* __restrict packed, int row_count, int depth, const float* __restrict x,
             float* __restrict y) {
  for (int row = 0; row < row_count; row += kRowBlock, packed += kRowBlock * depth) {
    for (int column = 0; column < kTile; column += kColumns * kLanes) {
      Vector sum[kRowBlock][kColumns] = {};
      const float* a = packed;
      const float* b = x + column;
      for (int k = 0; k < depth; ++k, a += kRowBlock, b += kTile) {
        Vector bk[kColumns];
#pragma GCC unroll 4
        for (int v = 0; v < kColumns; ++v) bk[v] = load(b + v * kLanes);
#pragma GCC unroll 6
        for (int r = 0; r < kRowBlock; ++r) {
#pragma GCC unroll 4
          for (int v = 0; v < kColumns; ++v) sum[r][v] += a[r] * bk[v];
        }
      }
#pragma GCC unroll 6
      for (int r = 0; r < kRowBlock; ++r) {
#pragma GCC unroll 4
        for (int v = 0; v < kColumns; ++v) {
          store(y + (row + r) * kTile + column + v * kLanes, sum[r][v]);
        }
      }
    }
  }
}

void fold(const float* planes, std::int64_t stride, int segments, int nodes, float* even,
          float* odd) {
  const int length = kTile / segments;
  for (int c = 0; c < nodes / 2; ++c) {
    for (int s = 0; s < segments; ++s) {
      const float* front = planes + (std::int64_t{c} * segments + s) * stride;
      const float* back = planes + (std::int64_t{nodes - 1 - c} * segments + s) * stride;
      const int at = c * kTile + s * length;
      for (int i = 0; i < length; i += kLanes) {
        const Vector a = load(front + i), b = load(back + i);
        store(even + at + i, a + b);
        store(odd + at + i, a - b);
      }
    }
  }
}

void unfold(const float* even, const float* odd, int nodes, float* x) {
  for (int c = 0; c < nodes / 2; ++c) {
    for (int i = 0; i < kTile; i += kLanes) {
      const Vector a = load(even + c * kTile + i), b = load(odd + c * kTile + i);
      store(x + c * kTile + i, a + b);
      store(x + (nodes - 1 - c) * kTile + i, a - b);
    }
  }
}

void combine(const float* weight, int width, const float* x, float* out) {
  for (int column = 0; column < kTile; column += 4 * kLanes) {
    Vector sum[4] = {};
    for (int w = 0; w < width; ++w) {
#pragma GCC unroll 4
      for (int v = 0; v < 4; ++v) sum[v] += weight[w] * load(x + w * kTile + column + v * kLanes);
    }
#pragma GCC unroll 4
    for (int v = 0; v < 4; ++v) store(out + column + v * kLanes, sum[v]);
  }
}

void store_complex(const float* __restrict tile, const float* __restrict added, int count,
                   float* __restrict out) {
  const float* re = tile;
  const float* im = tile + kTile / 2;
  if (added == nullptr) {
    for (int i = 0; i < count; ++i) {
      out[2 * i] = re[i];
      out[2 * i + 1] = im[i];
    }
    return;
  }
  for (int i = 0; i < count; ++i) {
    out[2 * i] = re[i] + added[i];
    out[2 * i + 1] = im[i] + added[kTile / 2 + i];
  }
}

// Rounding in the transforms can make samples without echoes negative.
void store_power(const float* __restrict tile, int count, float* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = tile[i] > 0 ? tile[i] : 0.0f;
}

void add_square(const float* __restrict tile, int count, float* __restrict out) {
  const float* re = tile;
  const float* im = tile + kTile / 2;
  for (int i = 0; i < count; ++i) out[i] += re[i] * re[i] + im[i] * im[i];
}

// Included here, because it calls the functions above.
#include "synthesis/cpu/kernels_array.inl"

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels = {draw_normals,  turn_paths,     apply_paths, place,       deposit,
                          deposit_draws, add_scaled,     widen,       widen_draws, narrow,
                          multiply,      multiply_add,   product,     fold,        unfold,
                          combine,       store_complex,  store_power, add_square,  array_paths,
                          array_deposit, widen_elements, array_beam,  array_steer, array_nodes};

}  // namespace ensonify::ENSONIFY_LEVEL
