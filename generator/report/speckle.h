// Whether the speckle of a data set has the statistics that theory gives it. Private to report/.
//
//   speckle_of    sums over one ping's pixels
//   Speckle  speckle_from   histogram, mean and contrast of all
//
// x = I / <I> of a pixel: its intensity over the expected one (clean level and noise). Amplitudes
// of rough surfaces are complex normal, sums of them too, so that x is exponential, exp(-x), with
// mean and contrast 1. That holds of pixels which
//   - are labelled with a surface that throws nothing back coherently,
//   - lie in no row (nor two next to it) where a point target or a coherent surface is labelled,
//     whose side lobes reach along the row,
//   - expect 15 dB more than the noise, and no less than 40 dB under the ping's highest level.
// Where there are no masks, all pixels are used if all instances are such surfaces, else none.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dataset/read_pictures.h"
#include "report/survey.h"

namespace ensonify {

inline constexpr int kSpeckleSteps = 40;
inline constexpr double kSpeckleEnd = 8;  // of the last step

struct SpeckleSum {
  double pixels = 0, x = 0, xx = 0;
};

struct PingSpeckle {
  std::vector<std::uint64_t> counts;  // by steps; the last one: beyond them
  std::vector<SpeckleSum> groups;     // of beams far enough apart to be independent
};

// Empty where a picture, the clean level or a fit pixel is missing.
PingSpeckle speckle_of(const StoredPixels& pixels, const ShownSequence& sequence);

struct Speckle {
  std::vector<std::uint64_t> counts;
  std::uint64_t over = 0, pixels = 0, pings = 0;
  double mean = 0, contrast = 0;
  // By leaving out one group after another (jackknife): neighbours in a picture are correlated.
  double contrast_standard_error = 0;
};

// Of all shown pings, in their order. None where no pixel is fit.
std::optional<Speckle> speckle_from(const Survey& survey, std::span<const PingSpeckle> pings);

}  // namespace ensonify
