#include "core/moments.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/compile_targets.h"
#include "core/error.h"

namespace ensonify {
namespace {

// Eight samples are summed at once, and arrays of samples are padded to whole eights.
typedef double Eight __attribute__((vector_size(64)));
constexpr std::size_t kEight = 8;

std::size_t padded(std::size_t samples) { return (samples + kEight - 1) / kEight * kEight; }

// A beam's part of a block. Arrays of samples are padded. Behind the last sample there is nothing
// that is used.
struct BeamBlock {
  std::size_t count, stride;
  // [count][re, im, power]: all realizations but the first, which is subtracted from them, so that
  // small spreads around large means keep their digits.
  std::vector<double> offsets;
  std::vector<double> sums;           // [kMoments], of the offsets
  std::vector<double> re, im, power;  // means minus the previous means, which Chan's merge needs

  BeamBlock(std::size_t realizations, std::size_t samples)
      : count(realizations - 1),
        stride(padded(samples)),
        offsets(3 * count * stride),
        sums(kMoments * stride),
        re(stride),
        im(stride),
        power(stride) {}
  double* of(MomentRow moment) { return sums.data() + static_cast<std::size_t>(moment) * stride; }
};

// p and origin: a realization and the first one, as re, im, re, im ...
ENSONIFY_VECTOR_CLONES
void take_offsets(const float* __restrict p, const float* __restrict origin, std::size_t samples,
                  double* __restrict re, double* __restrict im, double* __restrict power) {
  for (std::size_t n = 0; n < samples; ++n) {
    const double x = p[2 * n], y = p[2 * n + 1], x0 = origin[2 * n], y0 = origin[2 * n + 1];
    re[n] = x - x0;
    im[n] = y - y0;
    power[n] = (x * x + y * y) - (x0 * x0 + y0 * y0);
  }
}

// here: BeamBlock::offsets. Writes the sums up to those of bins.
ENSONIFY_VECTOR_CLONES
void sum_beam(const double* here, std::size_t count, std::size_t stride, double* __restrict sums) {
  const auto get = [](const double* from, Eight& eight) {
    std::memcpy(&eight, from, sizeof eight);
  };
  for (std::size_t n = 0; n < stride; n += kEight) {
    Eight re{}, im{}, power{}, spread{}, power_spread{}, power_skew{}, bins_re{}, bins_im{};
    for (std::size_t k = 0; k < count; ++k) {  // none: here is null
      const double* p = here + 3 * k * stride + n;
      Eight x, y, i, later_x, later_y;
      get(p, x);
      get(p + stride, y);
      get(p + 2 * stride, i);
      get(p + 1, later_x);
      get(p + stride + 1, later_y);
      re += x;
      im += y;
      power += i;
      spread += x * x + y * y;
      power_spread += i * i;
      power_skew += i * i * i;
      bins_re += later_x * x + later_y * y;
      bins_im += later_y * x - later_x * y;
    }
    const auto put = [&](MomentRow moment, const Eight& sum) {
      std::memcpy(sums + static_cast<std::size_t>(moment) * stride + n, &sum, sizeof sum);
    };
    put(MomentRow::mean_re, re);
    put(MomentRow::mean_im, im);
    put(MomentRow::mean_power, power);
    put(MomentRow::spread, spread);
    put(MomentRow::power_spread, power_spread);
    put(MomentRow::power_skew, power_skew);
    put(MomentRow::bins_re, bins_re);
    put(MomentRow::bins_im, bins_im);
  }
}

// The sums of products with the next beam.
ENSONIFY_VECTOR_CLONES
void sum_beams(const double* here, const double* next, std::size_t count, std::size_t stride,
               double* __restrict beams_re, double* __restrict beams_im) {
  const auto get = [](const double* from, Eight& eight) {
    std::memcpy(&eight, from, sizeof eight);
  };
  for (std::size_t n = 0; n < stride; n += kEight) {
    Eight re{}, im{};
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t place = 3 * k * stride + n;
      Eight x, y, u, v;
      get(here + place, x);
      get(here + place + stride, y);
      get(next + place, u);
      get(next + place + stride, v);
      re += u * x + v * y;
      im += v * x - u * y;
    }
    std::memcpy(beams_re + n, &re, sizeof re);
    std::memcpy(beams_im + n, &im, sizeof im);
  }
}

// row: the moments of the beam before the block.
void take_beam(SeriesBlock block, int beam, std::size_t samples, const double* row,
               BeamBlock& here) {
  const std::size_t at = static_cast<std::size_t>(beam) * samples, stride = here.stride;
  const auto floats = [&](std::size_t k) {
    return reinterpret_cast<const float*>(block[k].data() + at);
  };
  double* out = here.offsets.data();
  for (std::size_t k = 1; k < block.size(); ++k, out += 3 * stride) {
    take_offsets(floats(k), floats(0), samples, out, out + stride, out + 2 * stride);
  }
  sum_beam(here.offsets.data(), here.count, stride, here.sums.data());
  const auto size = static_cast<double>(block.size());
  const float* const origin = floats(0);
  const double* const re = here.of(MomentRow::mean_re);
  const double* const im = here.of(MomentRow::mean_im);
  const double* const power = here.of(MomentRow::mean_power);
  for (std::size_t n = 0; n < samples; ++n) {
    const double x0 = origin[2 * n], y0 = origin[2 * n + 1];
    here.re[n] = (x0 - row[n]) + re[n] / size;
    here.im[n] = (y0 - row[samples + n]) + im[n] / size;
    here.power[n] = ((x0 * x0 + y0 * y0) - row[2 * samples + n]) + power[n] / size;
  }
}

// Of two means of samples, of this beam and of another one or another sample.
struct Pair {
  const double *re, *im;
};

// to += the sums of products, less the product of the sums, plus that of the steps.
ENSONIFY_VECTOR_CLONES
void merge_products(Pair sums, Pair other_sums, Pair steps, Pair other_steps, Pair products,
                    std::size_t count, double size, double weight, double* __restrict to_re,
                    double* __restrict to_im) {
  for (std::size_t n = 0; n < count; ++n) {
    const double a = sums.re[n], b = sums.im[n], c = other_sums.re[n], d = other_sums.im[n];
    const double e = steps.re[n], f = steps.im[n], g = other_steps.re[n], h = other_steps.im[n];
    to_re[n] += products.re[n] - (c * a + d * b) / size;
    to_im[n] += products.im[n] - (d * a - c * b) / size;
    to_re[n] += weight * (g * e + h * f);
    to_im[n] += weight * (h * e - g * f);
  }
}

// How the sums of a block count: weight of the squared step of a mean, share of the block in all.
struct MergeWeights {
  double size, weight, share;
};

// The third sums use the second ones from before this block (Pebay 2008).
ENSONIFY_VECTOR_CLONES
void merge_spreads(const double* __restrict sums, std::size_t stride, Pair steps,
                   const double* __restrict power_step, std::size_t samples, MergeWeights by,
                   double* __restrict spread, double* __restrict power_spread,
                   double* __restrict power_skew) {
  const double* const re = sums;
  const double* const im = sums + stride;
  const double* const power = sums + 2 * stride;
  const double* const square = sums + 4 * stride;
  const double* const cube = sums + 5 * stride;
  for (std::size_t n = 0; n < samples; ++n) {
    const double x = steps.re[n], y = steps.im[n], i = power_step[n], mean = power[n] / by.size;
    const double block_spread = square[n] - power[n] * power[n] / by.size;
    power_skew[n] += cube[n] - mean * (3 * square[n] - 2 * power[n] * mean);
    power_skew[n] += by.weight * (1 - 2 * by.share) * (i * i * i);
    power_skew[n] += 3 * i * ((1 - by.share) * block_spread - by.share * power_spread[n]);
    spread[n] += sums[3 * stride + n] - (re[n] * re[n] + im[n] * im[n]) / by.size;
    power_spread[n] += block_spread;
    spread[n] += by.weight * (x * x + y * y);
    power_spread[n] += by.weight * (i * i);
  }
}

// row: the beam's moments; next: null at the last beam.
void merge(BeamBlock& here, BeamBlock* next, std::size_t samples, std::uint64_t count,
           double* row) {
  const double size = static_cast<double>(here.count + 1), before = static_cast<double>(count);
  const double share = size / (before + size), weight = before * share;
  const auto at = [&](MomentRow moment) {
    return row + static_cast<std::size_t>(moment) * samples;
  };
  const Pair sums{here.of(MomentRow::mean_re), here.of(MomentRow::mean_im)};
  const Pair steps{here.re.data(), here.im.data()};
  merge_spreads(here.sums.data(), here.stride, steps, here.power.data(), samples,
                {size, weight, share}, at(MomentRow::spread), at(MomentRow::power_spread),
                at(MomentRow::power_skew));
  merge_products(sums, {sums.re + 1, sums.im + 1}, steps, {steps.re + 1, steps.im + 1},
                 {here.of(MomentRow::bins_re), here.of(MomentRow::bins_im)}, samples - 1, size,
                 weight, at(MomentRow::bins_re), at(MomentRow::bins_im));
  if (next != nullptr) {
    sum_beams(here.offsets.data(), next->offsets.data(), here.count, here.stride,
              here.of(MomentRow::beams_re), here.of(MomentRow::beams_im));
    merge_products(sums, {next->of(MomentRow::mean_re), next->of(MomentRow::mean_im)}, steps,
                   {next->re.data(), next->im.data()},
                   {here.of(MomentRow::beams_re), here.of(MomentRow::beams_im)}, samples, size,
                   weight, at(MomentRow::beams_re), at(MomentRow::beams_im));
  }
  for (std::size_t n = 0; n < samples; ++n) {
    at(MomentRow::mean_re)[n] += share * here.re[n];
    at(MomentRow::mean_im)[n] += share * here.im[n];
    at(MomentRow::mean_power)[n] += share * here.power[n];
  }
}

}  // namespace

void add_block(SeriesBlock block, std::uint64_t count, int first, int last, Moments& moments) {
  ENSONIFY_ASSERT(!block.empty() && moments.samples > 0);
  const auto samples = static_cast<std::size_t>(moments.samples);
  const auto row_of = [&](int beam) {
    return moments.values.data() + static_cast<std::size_t>(beam) * moments.row_values();
  };
  BeamBlock here(block.size(), samples), next = here;
  if (first < last) take_beam(block, first, samples, row_of(first), here);
  for (int beam = first; beam < last; ++beam) {
    const bool has_next = beam + 1 < moments.beams;
    if (has_next) take_beam(block, beam + 1, samples, row_of(beam + 1), next);
    merge(here, has_next ? &next : nullptr, samples, count, row_of(beam));
    std::swap(here, next);
  }
}

Ratios ratios(double mean_power, double power_spread, double power_skew, std::uint64_t n) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(n);
  Ratios result{n > 1 ? power_spread / (count - 1) : kNone, kNone, kNone, kNone};
  if (!(mean_power > 0)) return result;
  const double squares = power_spread / count / (mean_power * mean_power);
  const double cubes = power_skew / count / (mean_power * mean_power * mean_power);
  result.contrast = std::sqrt(result.power_variance) / mean_power;
  result.fourth_moment = 1 + squares;
  result.third_moment = 1 + 3 * squares + cubes;
  return result;
}

}  // namespace ensonify
