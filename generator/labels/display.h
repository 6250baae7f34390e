// 8-bit images of levels, both those of the data set and rendered ones.
//
//   DisplayTable  display_table   a display at the ranges of a sequence
//   DisplayedImage  displayed     the gray levels of a polar image
//   EchoLevels  echo_levels  default_limits_db   the limits if none are given
//   db_limits_from_clean  db_limits_from_levels  the same for one image, without gain
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/display.h"
#include "core/ping.h"

namespace ensonify {

struct DisplayTable {
  Display display;
  double alpha_db_m = 0;       // of the gain; 0: none
  double step_m = 0;           // from sample to sample
  std::vector<double> tvg_db;  // [samples]
  // The level at which gray level k becomes k + 1, rising; the last is infinite.
  std::array<double, 256> steps_db{};
  // The search for the gray level of s begins at starts[(s - steps_db[0]) * starts_per_db] and ends
  // after `most_steps` comparisons.
  std::vector<std::int32_t> starts;
  double starts_per_db = 0;
  int most_steps = 0;
};

// tvg_db[n] = spreading log10(r / 1 m) + 2 alpha r with r = first_range_m + n step_m, but at least
// step_m.
// Gray level k begins where the image would show k - 1/2: with limits b and w at
// s = b + (k - 1/2) (w - b) / 255 (db), or s = w + 20 / gamma log10((k - 1/2) / 255) (amplitude).
// `absorption_db_m`: alpha, one way. Needs b < w and gamma > 0.
DisplayTable display_table(const Display& display, double absorption_db_m, double step_m,
                           int samples, double first_range_m = 0);

struct DisplayedImage {
  GreyImage grey;
  DisplayCounts counts;
  double further_gain_db = 0;  // constant and automatic gain
};

// [rows x columns], rows are samples: the rounded 255 (s - b) / (w - b), or
// 255 10^(gamma (s - w) / 20), from 0 to 255; 0 without energy. Automatic gain shifts the level at
// rank 0.995 (n - 1), rounded down, of the n pixels with energy to the white limit of each image;
// gain_db is added to it. The caller applies `color_map` and `flip`. `elevation_rad`: NaN where a
// pixel holds no echo; empty, of a recording: every pixel with energy holds one.
DisplayedImage displayed(const DisplayTable& table, int rows, int columns,
                         std::span<const float> level_db, std::span<const float> elevation_rad);

// The levels that determine the limits of a data set, from its first pings.
struct EchoLevels {
  std::vector<float> db;
  std::uint64_t pixels = 0;  // of the images, with or without echoes
  void add(const EchoLevels& more);
};

// The expected levels plus time-varied gain of the pixels that hold an echo above the noise: their
// elevation is known, and their expected power is at least that of the noise. If there are no such
// pixels, the levels of all pixels with energy and an echo. Of a recording, which has no expected
// levels, the levels of all pixels with energy.
EchoLevels echo_levels(const DisplayTable& table, const LabelledImage& polar,
                       double noise_power_pa2);

// Limits in whole dB; [60, 120] if there are no levels. White is the lowest limit that speckle is
// expected to reach in at most 0.2 % of all pixels and 10 % of those in `levels`. Speckle with the
// mean L reaches w with the probability exp(-10^((w - L) / 10)). Black is 15 dB below the 5th
// percentile of the levels, but 45 to 75 dB below white.
std::array<double, 2> default_limits_db(EchoLevels levels);

// The same for the pixels of one image.
std::array<double, 2> db_limits_from_clean(std::span<const float> clean_db,
                                           std::span<const float> elevation_rad,
                                           double noise_power_pa2 = 0);

// ... and of an image without labels.
std::array<double, 2> db_limits_from_levels(std::span<const float> level_db);

}  // namespace ensonify
