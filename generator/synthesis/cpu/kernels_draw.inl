// Random draws and phases: scalar code in loops that the compiler turns into vectors.

typedef std::uint64_t Words __attribute__((vector_size(ENSONIFY_VECTOR_BYTES)));
typedef std::uint32_t HalfWords
    __attribute__((vector_size(ENSONIFY_VECTOR_BYTES / 2), aligned(4), may_alias));
constexpr int kWords = ENSONIFY_VECTOR_BYTES / 8;

// Products of the lower halves; the compiler would multiply all 64 bits.
inline Words multiply_low(Words a, Words b) {
#if defined(__AVX512F__)
  // Without a mask gcc 12 warns of its own header.
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

// Philox 4x32-10 of core/random.h with counters (ping, lo, hi, 0): its first two words. A lane of 64
// bits holds one word; what stands in its upper half does not matter.
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
  // Near one the distance to one is taken from the integer: a float has lost it.
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

void apply_path(double frequency_hz, float scale, const double* __restrict delay_s,
                const float* __restrict gain, const float* __restrict re,
                const float* __restrict im, int count, float* __restrict value) {
  for (int i = 0; i < count; ++i) {
    // 1e5 turns in double; what is left of the quarter turns fits a float.
    const double quarters = -4.0 * (frequency_hz * delay_s[i]);
    const double whole = __builtin_rint(quarters);
    const double period = whole - 4.0 * __builtin_floor(whole * 0.25);
    float sine, cosine;
    sine_cosine(static_cast<std::int32_t>(period),
                static_cast<float>((quarters - whole) * 1.5707963267948966), &sine, &cosine);
    const float a = scale * gain[i];
    const float x = a * re[i], y = a * im[i];
    value[2 * i] = x * cosine - y * sine;
    value[2 * i + 1] = x * sine + y * cosine;
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
