#include "formats/bytes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cpuid.h>
#include <immintrin.h>

#include "core/compile_targets.h"
#include "core/error.h"

namespace ensonify {
std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto at = [&](std::size_t i) -> std::uint32_t {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u;
  };
  std::string text;
  text.reserve(base64_bytes(bytes.size()));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t word = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
    text += kDigits[word >> 18];
    text += kDigits[word >> 12 & 63];
    text += i + 1 < bytes.size() ? kDigits[word >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? kDigits[word & 63] : '=';
  }
  return text;
}

namespace {

std::uint16_t to_half(float value) {
  constexpr std::int32_t kLargest = 0x477fe000, kSmallestNormal = 0x38800000,
                         kInfinity = 0x7f800000;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto magnitude = static_cast<std::int32_t>(bits & 0x7fffffffu);
  const std::int32_t clamped = magnitude > kLargest ? kLargest : magnitude;
  const std::int32_t normal = (clamped - 0x38000000 + 0xfff + (clamped >> 13 & 1)) >> 13;
  // The last bit of a float just above 1/2 is worth what the last one of a subnormal half is: the
  // sum is rounded there, half to even.
  const float sum = std::bit_cast<float>(clamped) + 0.5f;
  const std::int32_t subnormal = std::bit_cast<std::int32_t>(sum) - 0x3f000000;
  const std::int32_t number = (clamped < kSmallestNormal ? subnormal : normal) |
                              static_cast<std::int32_t>(bits >> 16 & 0x8000u);
  return static_cast<std::uint16_t>(magnitude > kInfinity ? 0x7fff : number);
}

// Without branches, so that compilers make vectors of it.
inline float from_half(std::uint16_t half) {
  const std::int32_t sign = (half & 0x8000) << 16, magnitude = half & 0x7fff;
  const auto subnormal = std::bit_cast<std::int32_t>(static_cast<float>(magnitude) * 0x1p-24f);
  const std::int32_t exponent = magnitude >= 0x7c00 ? 0x70000000 : 0x38000000;
  const std::int32_t normal = (magnitude << 13) + exponent;
  return std::bit_cast<float>(sign | (magnitude < 0x400 ? subnormal : normal));
}

ENSONIFY_VECTOR_CLONES void convert_back(const std::uint16_t* __restrict halves, std::size_t count,
                                         float* __restrict values) {
  for (std::size_t i = 0; i < count; ++i) values[i] = from_half(halves[i]);
}

#if defined(__x86_64__)
// to_half by the processor's conversion, eight at once; returns how many were converted.
__attribute__((target("avx,f16c"))) std::size_t convert_eights(const float* values,
                                                               std::uint16_t* halves,
                                                               std::size_t count) {
  const __m256 largest = _mm256_set1_ps(65504.0f), smallest = _mm256_set1_ps(-65504.0f);
  const __m128i nan = _mm_set1_epi16(0x7fff);
  std::size_t done = 0;
  for (; done + 8 <= count; done += 8) {
    const __m256 x = _mm256_loadu_ps(values + done);
    // In this order a NaN passes both limits.
    const __m256 clamped = _mm256_min_ps(largest, _mm256_max_ps(smallest, x));
    const __m128i bits = _mm256_cvtps_ph(clamped, _MM_FROUND_TO_NEAREST_INT);
    const __m256i unordered = _mm256_castps_si256(_mm256_cmp_ps(x, x, _CMP_UNORD_Q));
    const __m128i is_nan =
        _mm_packs_epi32(_mm256_castsi256_si128(unordered), _mm256_extractf128_si256(unordered, 1));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(halves + done), _mm_blendv_epi8(bits, nan, is_nan));
  }
  return done;
}

// clang's __builtin_cpu_supports has no name for it; `avx` shows that the system saves the
// registers.
bool has_f16c() noexcept {
  unsigned a = 0, b = 0, c = 0, d = 0;
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx") && __get_cpuid(1, &a, &b, &c, &d) != 0 &&
         (c & bit_F16C) != 0;
}

// Queried once at start: in a virtual machine, each cpuid traps, which takes longer than converting
// a row.
const bool kHasF16c = has_f16c();
#endif

}  // namespace

void to_halves(std::span<const float> values, std::span<std::uint16_t> halves) {
  ENSONIFY_ASSERT(values.size() == halves.size());
  std::size_t i = 0;
#if defined(__x86_64__)
  if (kHasF16c) {
    i = convert_eights(values.data(), halves.data(), values.size());
  }
#endif
  for (; i < values.size(); ++i) halves[i] = to_half(values[i]);
}

void from_halves(std::span<const std::uint16_t> halves, std::span<float> values) {
  ENSONIFY_ASSERT(values.size() == halves.size());
  convert_back(halves.data(), halves.size(), values.data());
}

void round_to_halves(std::span<float> values) {
  std::array<std::uint16_t, 1024> halves;
  for (std::size_t done = 0; done < values.size(); done += halves.size()) {
    const auto part = values.subspan(done, std::min(halves.size(), values.size() - done));
    const auto bits = std::span(halves).first(part.size());
    to_halves(part, bits);
    from_halves(bits, part);
  }
}

}  // namespace ensonify
