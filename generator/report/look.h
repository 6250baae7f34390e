// Results of a first pass over the images of the shown pings. Private to report/.
//
//   PictureJob  pixels_of  for_each_picture
//   PictureScale  grey_code        meaning of the codes of images
//   PingSpeckle  speckle_of        sums over one ping's pixels
//   Speckle  speckle_from          histogram, mean and contrast of all: whether the speckle of a
//                                  data set has the statistics that theory gives it
//   Look  look_at
//   LevelCounts  scale_of          levels of images that one display shows
//
// x = I / <I> of a pixel: its intensity relative to the expected one (expected level and noise).
// Amplitudes of rough surfaces and their sums are complex normal, so that x is exponential,
// exp(-x), with mean and contrast 1. This is true for pixels that
//   - are labeled with a surface without a coherent part,
//   - lie in no row (nor two next to it) where a point target or a coherent surface is labeled,
//     whose side lobes reach along the row,
//   - expect 15 dB more than the noise, and no less than 40 dB under the ping's highest level.
// Without masks, all pixels are used if all instances are such surfaces, and otherwise none.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/units.h"
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

// Empty if an image, the expected level or a suitable pixel is missing.
PingSpeckle speckle_of(const StoredPixels& pixels, const ShownSequence& sequence);

struct Speckle {
  std::vector<std::uint64_t> counts;
  std::uint64_t over = 0, pixels = 0, pings = 0;
  double mean = 0, contrast = 0;
  // Jackknife over groups of beams, since neighboring pixels are correlated.
  double contrast_standard_error = 0;
};

// The speckle of all shown pings, in their order. None if no pixel is suitable.
std::optional<Speckle> speckle_from(const Survey& survey, std::span<const PingSpeckle> pings);

struct PictureScale {
  double min_db = 0, max_db = 1;            // of codes 1 and 255
  double show_min_db = 0, show_max_db = 1;  // of the first view
  std::optional<double> min_rad, max_rad;   // of elevations; absent: there is none
};

// Returns 0 for NaN and 1 to 255 for values from low to high.
std::uint8_t grey_code(double value, double low, double high);

struct Look {
  PictureScale scale;
  std::optional<Speckle> speckle;
};

// Inputs shared by all code that reads images.
struct PictureJob {
  const StoredDataset& dataset;
  const Survey& survey;
  const Workers& workers;
  bool (*stop)() = nullptr;
};

// The polar image or, if there is none, levels of the time series.
Result<StoredPixels> pixels_of(const PictureJob& job, const ShownPing& ping);

Result<Look> look_at(const PictureJob& job);

// How many pixels have which level, in steps of 1 dB, and the highest level.
struct LevelCounts {
  static constexpr int kLeastDb = -99, kSteps = 400;
  std::array<std::uint64_t, kSteps> steps{};
  float highest_db = kNoEnergyDb;

  void add(std::span<const float> levels_db);
  void add(const LevelCounts& others);
};

// Codes down to 100 dB below the highest level; a first view that shows most pixels, between limits
// at multiples of 5 dB.
PictureScale scale_of(const LevelCounts& levels);

// Calls use(i) for all i below `count` in parallel; returns the Error of the lowest i, or that the
// user stopped it.
Status for_each_picture(const Workers& workers, bool (*stop)(), std::size_t count,
                        const std::function<Status(std::size_t)>& use);

}  // namespace ensonify
