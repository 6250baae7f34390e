// Angles and levels. Inside the code: SI units and radians; dB only at the edges.
//
//   kPi  radians  degrees
//   level_db  mean_square_pa2
//   image_level_db   level_db in single precision, in a form that vectorizes
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/compile_targets.h"

namespace ensonify {

inline constexpr double kPi = 3.14159265358979323846;

// The level of a pixel that holds no energy at all, in every image and file.
inline constexpr float kNoEnergyDb = -99.0f;

ENSONIFY_HD constexpr double radians(double degrees) { return degrees * (kPi / 180.0); }
ENSONIFY_HD constexpr double degrees(double radians) { return radians * (180.0 / kPi); }

// Level of a mean square pressure in dB re 1 uPa; kNoEnergyDb at and below zero.
ENSONIFY_HD inline float level_db(double mean_square_pa2) {
  if (!(mean_square_pa2 > 0)) return kNoEnergyDb;
  const double level = 10.0 * std::log10(mean_square_pa2) + 120.0;
  return level > kNoEnergyDb ? static_cast<float>(level) : kNoEnergyDb;
}

// Mean square pressure in Pa^2 of a level in dB re 1 uPa.
ENSONIFY_HD inline double mean_square_pa2(double level_db) {
  return std::pow(10.0, (level_db - 120.0) / 10.0);
}

// level_db of a mean square pressure, within 3e-5 dB; images are stored in half precision, whose
// steps are 0.016 dB and more above 16 dB. Infinity has 505 dB, the most that a float can.
// With x = 2^e m, m in [sqrt(1/2), sqrt(2)), and s = (m - 1) / (m + 1):
//   10 lg x = 10 lg 2 e + 20 / ln 10 (s + s^3 / 3 + s^5 / 5 + ...),
// and the omitted terms are below 6e-6 dB. All x take the same steps, and a bit mask makes the
// choice, since compilers turn anything else into a branch and then do not vectorize.
// __builtin_bit_cast, since CUDA refuses the host's std::bit_cast on the device.
ENSONIFY_HD inline float image_level_db(float mean_square_pa2) {
  constexpr std::uint32_t kSqrtHalfBits = 0x3f3504f3;
  constexpr float kDbPerOctave = 3.01029996f, kTwentyByLn10 = 8.68588964f;
  constexpr float kLeast_pa2 = 1.25892541e-22f;  // kNoEnergyDb
  const auto bits = __builtin_bit_cast(std::uint32_t, mean_square_pa2);
  const std::int32_t exponent = static_cast<std::int32_t>(bits - kSqrtHalfBits) >> 23;
  const float m = __builtin_bit_cast(float, bits - (static_cast<std::uint32_t>(exponent) << 23));
  const float s = (m - 1.0f) / (m + 1.0f);
  const float square = s * s;
  const float series = s * (1.0f + square * (1.0f / 3.0f + square * (1.0f / 5.0f)));
  const float level =
      (static_cast<float>(exponent) * kDbPerOctave + 120.0f) + kTwentyByLn10 * series;
  const std::uint32_t holds = 0u - static_cast<std::uint32_t>(mean_square_pa2 > kLeast_pa2);
  return __builtin_bit_cast(float, (__builtin_bit_cast(std::uint32_t, level) & holds) |
                                       (__builtin_bit_cast(std::uint32_t, kNoEnergyDb) & ~holds));
}

}  // namespace ensonify
