// Angles and levels. Inside the code: SI units and radians; dB only at the edges.
#pragma once

#include <cmath>
#include <limits>

#include "core/host_device.h"

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

}  // namespace ensonify
