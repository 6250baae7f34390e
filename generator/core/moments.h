// Moments of the time series over independent speckle draws of one scene, for each pixel: a speckle
// study stores these instead of its pings. docs/physics/4_speckle.md, has the formulas.
//
//   Moments          central sums of n realizations; memory does not grow with n
//   add_block        merges a block of realizations, some beams at a time
//   Ratios           ratios of the moments at one pixel
//   PooledPixels  pool_of    the pixels that histogram and lags are taken over
//   add_pooled       adds a block of realizations to the sums over these pixels
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/samples.h"

namespace ensonify {

// Realizations that are summed together before they are merged (Chan, Golub and LeVeque 1983). The
// order of all sums follows from it, so it is part of a data set's bytes.
inline constexpr std::uint32_t kMomentBlock = 8;

// Sums for each pixel; m and M are the means of p and of I = |p|^2.
enum class MomentRow {
  mean_re,       // of p, Pa
  mean_im,       //
  mean_power,    // of I, Pa^2
  spread,        // sum |p - m|^2
  power_spread,  // sum (I - M)^2
  power_skew,    // sum (I - M)^3
  bins_re,       // sum (p' - m') (p - m)*, p' one sample later; 0 at the last sample
  bins_im,       //
  beams_re,      // the same, p' one beam on; 0 at the last beam
  beams_im
};
inline constexpr int kMoments = 10;

// Sums of a beam over its pooled pixels and all realizations, of u = p / sqrt(E I) and x = |u|^2.
enum class PooledRow {
  histogram,  // [kHistogramBins] pixels by x; x in [k, k + 1) kHistogramStep, the last without end
  bins_re,    // [lags + 1] sum u' u*, u' as many samples later as the lag; these need lags > 0
  bins_im,
  bins_power,  // [lags + 1] sum x' x
  beams_re,    // [lags + 1] the same, u' as many beams on
  beams_im,
  beams_power
};
inline constexpr int kHistogramBins = 201;
inline constexpr double kHistogramStep = 0.1;

struct Moments {
  int beams = 0, samples = 0;
  int lags = 0;                // 0: no sums of products
  std::uint64_t count = 0;     // realizations in them
  std::vector<double> values;  // [beams x (kMoments x samples, then the rows of PooledRow)]

  Moments() = default;
  Moments(int beams_, int samples_, int lags_ = 0) : beams(beams_), samples(samples_), lags(lags_) {
    values.resize(std::size_t(beams) * row_values());
  }

  std::size_t pooled_values() const {
    return std::size_t(kHistogramBins) + (lags > 0 ? 6 * (std::size_t(lags) + 1) : 0);
  }
  std::size_t row_values() const { return std::size_t(kMoments) * samples + pooled_values(); }
  std::span<const double> of(MomentRow moment, int beam) const {
    return std::span(values).subspan(
        std::size_t(beam) * row_values() + static_cast<std::size_t>(moment) * samples, samples);
  }
  std::span<const double> of(PooledRow row, int beam) const {
    const std::size_t first = std::size_t(beam) * row_values() + std::size_t(kMoments) * samples;
    if (row == PooledRow::histogram) return std::span(values).subspan(first, kHistogramBins);
    const std::size_t each = std::size_t(lags) + 1, before = static_cast<std::size_t>(row) - 1;
    return std::span(values).subspan(first + kHistogramBins + before * each, each);
  }
};

// Series of some realizations, [beams x samples] each.
using SeriesBlock = std::span<const Series>;

// Merges a block into beams [first, last) of moments that hold `count` realizations there and in
// beam `last`. Beams must be processed in rising order; the caller increases `Moments::count`. The
// result depends only on the block and on the previous moments. Needs series of beams x samples
// values.
void add_block(SeriesBlock block, std::uint64_t count, int first, int last, Moments& moments);

// The ratios of one pixel from n >= 2 realizations; NaN if a denominator is 0.
struct Ratios {
  double power_variance = 0;  // of I, unbiased, Pa^4
  double contrast = 0;        // standard deviation of I / mean of I
  double fourth_moment = 0;   // <|p|^4> / <|p|^2>^2
  double third_moment = 0;    // <I^3> / <I>^3
};
Ratios ratios(double mean_power, double power_spread, double power_skew, std::uint64_t n);

// The expected intensities of a scene, and 1 / sqrt(expected) of the pixels that are pooled: those
// within `within_db` of the largest. The others have 0.
struct PooledPixels {
  std::vector<double> expected_pa2, weight;  // [beams x samples]
};
PooledPixels pool_of(std::vector<double> expected_pa2, double within_db);

// Adds a block to the pooled sums of beams [first, last). In contrast to add_block, beams may be
// processed in any order.
void add_pooled(SeriesBlock block, const PooledPixels& pool, int first, int last, Moments& moments);

}  // namespace ensonify
