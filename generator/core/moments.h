// Moments of the time series over independent speckle draws of one scene, for each pixel: a speckle
// study stores these instead of its pings. docs/physics/4_speckle.md, has the formulas.
//
//   Moments          central sums of n realizations; memory does not grow with n
//   add_block        merges a block of realizations, some beams at a time
//   Ratios           ratios of the moments at one pixel
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

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
  bins_re,       // sum (p' - m') (p - m)*, p' one sample later; 0 at the last sample
  bins_im,       //
  beams_re,      // the same, p' one beam on; 0 at the last beam
  beams_im
};
inline constexpr int kMoments = 9;

struct Moments {
  int beams = 0, samples = 0;
  std::uint64_t count = 0;     // realizations in them
  std::vector<double> values;  // [beams x kMoments x samples]

  Moments() = default;
  Moments(int beams_, int samples_)
      : beams(beams_), samples(samples_), values(std::size_t(beams_) * kMoments * samples_) {}

  std::size_t row_values() const { return std::size_t(kMoments) * samples; }
  std::span<const double> of(MomentRow moment, int beam) const {
    return std::span(values).subspan(
        (std::size_t(beam) * kMoments + static_cast<std::size_t>(moment)) * samples, samples);
  }
};

// Series of some realizations, [beams x samples] each.
using SeriesBlock = std::span<const std::vector<std::complex<float>>>;

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
};
Ratios ratios(double mean_power, double power_spread, std::uint64_t n);

}  // namespace ensonify
