// The work of one thread of a device for moments of realizations. The sums have the order and the
// rounding of core/moments.cpp and core/pooled_moments.cpp, so that the same series give the same
// bits there and here. Functors are as in beam_kernels.h.
//
//   Rounded        a double whose products are rounded before they are added
//   Realizations   the series of a batch
//   KeepMeans      the means before a batch, which neighboring pixels need
//   AddMoments     series -> central sums of pixels
//   CountPowers    series -> histograms of parts of a beam; AddCounts -> of beams
//   SumProducts    series -> products over lags, in parts; AddProducts -> of beams
#pragma once

#include <cstdint>

#include "core/moments.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// A compiler for devices would otherwise fuse a product with the sum around it, as the host's
// compiler must not (-ffp-contract=off).
struct Rounded {
  double value;
  ENSONIFY_HD Rounded(double v = 0) : value(v) {}
};
ENSONIFY_HD inline Rounded operator+(Rounded a, Rounded b) { return a.value + b.value; }
ENSONIFY_HD inline Rounded operator-(Rounded a, Rounded b) { return a.value - b.value; }
ENSONIFY_HD inline Rounded operator/(Rounded a, Rounded b) { return a.value / b.value; }
ENSONIFY_HD inline Rounded operator*(Rounded a, Rounded b) {
#if defined(__CUDA_ARCH__)
  return __dmul_rn(a.value, b.value);
#else
  return a.value * b.value;
#endif
}
ENSONIFY_HD inline void operator+=(Rounded& sum, Rounded part) { sum = sum + part; }

// series: [count][beams][samples].
struct Realizations {
  const Complex32* series;
  int count, beams, samples;

  ENSONIFY_HD std::int64_t cells() const { return std::int64_t{beams} * samples; }
};

// Writes means [beams][re, im][samples] from moments as Moments::values, row_values for each beam.
// The count is beams times 2 times samples.
struct KeepMeans {
  const double* values;
  std::int64_t row_values;
  int samples;
  double* means;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t row = 2 * std::int64_t{samples};
    means[i] = values[i / row * row_values + i % row];
  }
};

// How the sums of a block count: its size, the weight of the squared step of a mean, and the share
// of the block in all realizations.
struct BlockWeights {
  Rounded size, weight, share;
};

// p at one pixel through the blocks of a batch. Offsets are from the first realization of a block.
struct PixelTrack {
  const Complex32* series;
  Rounded mean_re, mean_im;  // before the block
  Rounded first_re, first_im, re, im, sum_re, sum_im;

  ENSONIFY_HD void begin(std::int64_t at) {
    first_re = series[at].re;
    first_im = series[at].im;
    sum_re = sum_im = 0;
  }
  ENSONIFY_HD void take(std::int64_t at) {
    re = Rounded(series[at].re) - first_re;
    im = Rounded(series[at].im) - first_im;
    sum_re += re;
    sum_im += im;
  }
  // The mean of the block minus that of all realizations before.
  ENSONIFY_HD Rounded step_re(Rounded size) const { return (first_re - mean_re) + sum_re / size; }
  ENSONIFY_HD Rounded step_im(Rounded size) const { return (first_im - mean_im) + sum_im / size; }
  ENSONIFY_HD void finish(const BlockWeights& by) {
    const Rounded x = step_re(by.size), y = step_im(by.size);
    mean_re += by.share * x;
    mean_im += by.share * y;
  }
};

// The sum of products of a pixel and a neighbor.
struct ProductTrack {
  Rounded all_re, all_im;  // of all blocks before
  Rounded re, im;          // of the block's offsets

  ENSONIFY_HD void take(const PixelTrack& here, const PixelTrack& other) {
    re += other.re * here.re + other.im * here.im;
    im += other.im * here.re - other.re * here.im;
  }
  ENSONIFY_HD void finish(const PixelTrack& here, const PixelTrack& other, const BlockWeights& by) {
    const Rounded a = here.sum_re, b = here.sum_im, c = other.sum_re, d = other.sum_im;
    const Rounded e = here.step_re(by.size), f = here.step_im(by.size);
    const Rounded g = other.step_re(by.size), h = other.step_im(by.size);
    all_re += re - (c * a + d * b) / by.size;
    all_im += im - (d * a - c * b) / by.size;
    all_re += by.weight * (g * e + h * f);
    all_im += by.weight * (h * e - g * f);
    re = im = 0;
  }
};

// The intensity of a pixel, and the spread of p.
struct PowerTrack {
  Rounded mean, spread, square, cube;                    // of all blocks before
  Rounded first, sum, sum_spread, sum_square, sum_cube;  // of the block's offsets

  ENSONIFY_HD void begin(const PixelTrack& p) {
    first = p.first_re * p.first_re + p.first_im * p.first_im;
    sum = sum_spread = sum_square = sum_cube = 0;
  }
  ENSONIFY_HD void take(const PixelTrack& p, Complex32 value) {
    const Rounded x = value.re, y = value.im, i = (x * x + y * y) - first;
    sum += i;
    sum_spread += p.re * p.re + p.im * p.im;
    sum_square += i * i;
    sum_cube += i * i * i;
  }
  ENSONIFY_HD void finish(const PixelTrack& p, const BlockWeights& by) {
    const Rounded x = p.step_re(by.size), y = p.step_im(by.size);
    const Rounded i = (first - mean) + sum / by.size, block_mean = sum / by.size;
    const Rounded block_square = sum_square - sum * sum / by.size;
    cube += sum_cube - block_mean * (3 * sum_square - 2 * sum * block_mean);
    cube += by.weight * (1 - 2 * by.share) * (i * i * i);
    cube += 3 * i * ((1 - by.share) * block_square - by.share * square);
    spread += sum_spread - (p.sum_re * p.sum_re + p.sum_im * p.sum_im) / by.size;
    square += block_square;
    spread += by.weight * (x * x + y * y);
    square += by.weight * (i * i);
    mean += by.share * i;
  }
};

// Adds realizations to moments that hold `before` of them, a whole number of blocks. The last block
// may be short. means: as KeepMeans writes them. The count is beams times samples.
struct AddMoments {
  Realizations all;
  double before;
  const double* means;
  std::int64_t row_values;
  double* values;

  ENSONIFY_HD PixelTrack track_of(std::int64_t cell) const {
    const std::int64_t beam = cell / all.samples, n = cell % all.samples;
    const double* mean = means + 2 * beam * all.samples + n;
    PixelTrack track{all.series + cell, mean[0], mean[all.samples], {}, {}, {}, {}, {}, {}};
    return track;
  }

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t beam = i / all.samples, n = i % all.samples, samples = all.samples;
    const bool has_bin = n + 1 < samples, has_beam = beam + 1 < all.beams;
    double* const row = values + beam * row_values + n;
    // A pixel without a neighbor follows itself, and leaves the sums of products alone.
    PixelTrack here = track_of(i), bin = track_of(has_bin ? i + 1 : i),
               next = track_of(has_beam ? i + samples : i);
    PowerTrack power{
        row[2 * samples], row[3 * samples], row[4 * samples], row[5 * samples], {}, {}, {}, {}, {}};
    ProductTrack bins{row[6 * samples], row[7 * samples], {}, {}},
        beams{row[8 * samples], row[9 * samples], {}, {}};
    constexpr int kBlock = kMomentBlock;
    for (int first = 0; first < all.count; first += kBlock) {
      const int size = all.count - first < kBlock ? all.count - first : kBlock;
      const Rounded count = before + first, whole = size, share = whole / (count + whole);
      const BlockWeights by{whole, count * share, share};
      std::int64_t at = first * all.cells();
      here.begin(at);
      bin.begin(at);
      next.begin(at);
      power.begin(here);
      for (int k = 1; k < size; ++k) {
        at += all.cells();
        here.take(at);
        bin.take(at);
        next.take(at);
        power.take(here, here.series[at]);
        bins.take(here, bin);
        beams.take(here, next);
      }
      power.finish(here, by);
      bins.finish(here, bin, by);
      beams.finish(here, next, by);
      here.finish(by);
      bin.finish(by);
      next.finish(by);
    }
    const Rounded sums[] = {here.mean_re, here.mean_im, power.mean,  power.spread, power.square,
                            power.cube,   bins.all_re,  bins.all_im, beams.all_re, beams.all_im};
    for (int moment = 0; moment < kMoments; ++moment) {
      if ((moment >= 6 && moment < 8 && !has_bin) || (moment >= 8 && !has_beam)) continue;
      row[moment * samples] = sums[moment].value;
    }
  }
};

// u of a pixel: p divided by the root of its expected intensity. x = |u|^2.
struct PooledPixel {
  Rounded re, im;
  ENSONIFY_HD PooledPixel(Complex32 p, double weight)
      : re(Rounded(p.re) * weight), im(Rounded(p.im) * weight) {}
  ENSONIFY_HD Rounded power() const { return re * re + im * im; }
};

// A beam's pixels are counted by this number of threads.
constexpr int kCountLanes = 64;

// Writes counts [beams][kHistogramBins][kCountLanes]. weight: PooledPixels::weight. The count is
// beams times kCountLanes.
struct CountPowers {
  Realizations all;
  const double* weight;
  std::uint32_t* counts;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t beam = i / kCountLanes, lane = i % kCountLanes;
    std::uint32_t* own = counts + beam * kHistogramBins * kCountLanes + lane;
    for (int bin = 0; bin < kHistogramBins; ++bin) own[bin * kCountLanes] = 0;
    for (std::int64_t n = lane; n < all.samples; n += kCountLanes) {
      const std::int64_t cell = beam * all.samples + n;
      const double w = weight[cell];
      for (int k = 0; w != 0 && k < all.count; ++k) {
        const Rounded power = PooledPixel(all.series[k * all.cells() + cell], w).power();
        const double bin = (power / kHistogramStep).value;
        constexpr int kLast = kHistogramBins - 1;
        own[(bin < kLast ? static_cast<int>(bin) : kLast) * kCountLanes] += 1;
      }
    }
  }
};

// Adds the counts to the histograms in `values`, the first of which starts at `histogram`. The
// count is beams times kHistogramBins.
struct AddCounts {
  const std::uint32_t* counts;
  std::int64_t row_values;
  double* histogram;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    std::uint64_t sum = 0;
    for (int lane = 0; lane < kCountLanes; ++lane) sum += counts[i * kCountLanes + lane];
    histogram[i / kHistogramBins * row_values + i % kHistogramBins] += static_cast<double>(sum);
  }
};

// Sums over the samples of a beam have this number of parts, as those of core/pooled_moments.cpp.
constexpr int kProductParts = 8;

// Writes parts [count][beams][bins, beams][lags + 1][re, im, power][kProductParts]. The count is
// that of `parts` without re, im and power.
struct SumProducts {
  Realizations block;
  const double* weight;
  int lags;
  double* parts;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t part = i % kProductParts, sum = i / kProductParts, samples = block.samples;
    const std::int64_t lag = sum % (lags + 1), row = sum / (lags + 1);
    const bool is_range = row % 2 == 0;
    const std::int64_t beam = row / 2 % block.beams, realization = row / 2 / block.beams;
    const std::int64_t shift = is_range ? lag : lag * samples;
    const bool has_other = is_range || beam + lag < block.beams;
    const std::int64_t end = !has_other ? 0 : is_range ? samples - lag : samples;
    const double* const weights = weight + beam * samples;
    const Complex32* const series = block.series + realization * block.cells() + beam * samples;
    Rounded re, im, power;
    for (std::int64_t n = part; n < end; n += kProductParts) {
      if (weights[n] == 0 || weights[n + shift] == 0) continue;
      const PooledPixel here(series[n], weights[n]), other(series[n + shift], weights[n + shift]);
      re += other.re * here.re + other.im * here.im;
      im += other.im * here.re - other.re * here.im;
      power += other.power() * here.power();
    }
    double* const out = parts + sum * 3 * kProductParts + part;
    out[0] = re.value;
    out[kProductParts] = im.value;
    out[2 * kProductParts] = power.value;
  }
};

// Adds the parts of `realizations` to the products in `values`, the first of which start at
// `products`. The count is beams times 2 times (lags + 1) times 3.
struct AddProducts {
  const double* parts;
  int realizations, beams, lags;
  std::int64_t row_values;
  double* products;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t each = 2 * std::int64_t{3} * (lags + 1), beam = i / each;
    const std::int64_t component = i % 3, lag = i / 3 % (lags + 1),
                       direction = i % each / 3 / (lags + 1);
    double* const to =
        products + beam * row_values + (3 * direction + component) * (lags + 1) + lag;
    Rounded all = *to;
    for (int k = 0; k < realizations; ++k) {
      const double* const own = parts + (k * beams * each + i) * kProductParts;
      Rounded sum;
      for (int part = 0; part < kProductParts; ++part) sum += own[part];
      all += sum;
    }
    *to = all.value;
  }
};

}  // namespace ensonify
