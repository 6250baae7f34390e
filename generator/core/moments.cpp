#include "core/moments.h"

#include <cmath>
#include <limits>

#include "core/error.h"

namespace ensonify {
namespace {

// A beam's part of a block. The first realization is subtracted from each one, so that small
// spreads around large means keep their digits.
struct Offsets {
  std::vector<double> re, im, power;  // [samples]

  explicit Offsets(std::size_t samples) : re(samples), im(samples), power(samples) {}

  void take(const std::complex<float>* p, const std::complex<float>* origin) {
    for (std::size_t n = 0; n < re.size(); ++n) {
      const double x = p[n].real(), y = p[n].imag(), x0 = origin[n].real(), y0 = origin[n].imag();
      re[n] = x - x0;
      im[n] = y - y0;
      power[n] = (x * x + y * y) - (x0 * x0 + y0 * y0);
    }
  }
};

// Sums of a beam's offsets over a block, [kMoments x samples], and of the next beam's.
struct BlockSums {
  std::vector<double> values, next_re, next_im;

  explicit BlockSums(std::size_t samples)
      : values(kMoments * samples), next_re(samples), next_im(samples) {}
  double* of(MomentRow moment) {
    return values.data() + static_cast<std::size_t>(moment) * next_re.size();
  }
};

// Adds the sums of b a*.
void add_products(const double* a_re, const double* a_im, const double* b_re, const double* b_im,
                  std::size_t count, double* re, double* im) {
  for (std::size_t n = 0; n < count; ++n) {
    re[n] += b_re[n] * a_re[n] + b_im[n] * a_im[n];
    im[n] += b_im[n] * a_re[n] - b_re[n] * a_im[n];
  }
}

void add_to(const std::vector<double>& values, double* sums) {
  for (std::size_t n = 0; n < values.size(); ++n) sums[n] += values[n];
}

void add_offsets(const Offsets& here, const Offsets* next, BlockSums& sums) {
  const std::size_t samples = here.re.size();
  add_to(here.re, sums.of(MomentRow::mean_re));
  add_to(here.im, sums.of(MomentRow::mean_im));
  add_to(here.power, sums.of(MomentRow::mean_power));
  double* const spread = sums.of(MomentRow::spread);
  double* const power_spread = sums.of(MomentRow::power_spread);
  for (std::size_t n = 0; n < samples; ++n) {
    spread[n] += here.re[n] * here.re[n] + here.im[n] * here.im[n];
    power_spread[n] += here.power[n] * here.power[n];
  }
  add_products(here.re.data(), here.im.data(), here.re.data() + 1, here.im.data() + 1, samples - 1,
               sums.of(MomentRow::bins_re), sums.of(MomentRow::bins_im));
  if (next == nullptr) return;
  add_to(next->re, sums.next_re.data());
  add_to(next->im, sums.next_im.data());
  add_products(here.re.data(), here.im.data(), next->re.data(), next->im.data(), samples,
               sums.of(MomentRow::beams_re), sums.of(MomentRow::beams_im));
}

// Sums over the block at a beam, and at the next beam if it exists.
BlockSums sums_of(SeriesBlock block, int beam, bool has_next, int samples) {
  const auto count = static_cast<std::size_t>(samples);
  const std::size_t at = static_cast<std::size_t>(beam) * count;
  BlockSums sums(count);
  Offsets here(count), next(count);
  for (std::size_t k = 1; k < block.size(); ++k) {
    here.take(block[k].data() + at, block[0].data() + at);
    if (has_next) next.take(block[k].data() + at + count, block[0].data() + at + count);
    add_offsets(here, has_next ? &next : nullptr, sums);
  }
  return sums;
}

// Turns sums about the first realization into means relative to it, and central sums.
void centre(double block_size, bool has_next, BlockSums& sums) {
  const std::size_t samples = sums.next_re.size();
  double* const re = sums.of(MomentRow::mean_re);
  double* const im = sums.of(MomentRow::mean_im);
  double* const power = sums.of(MomentRow::mean_power);
  for (std::size_t n = 0; n < samples; ++n) {
    sums.of(MomentRow::spread)[n] -= (re[n] * re[n] + im[n] * im[n]) / block_size;
    sums.of(MomentRow::power_spread)[n] -= power[n] * power[n] / block_size;
  }
  const auto less_means = [&](const double* next_re, const double* next_im, std::size_t count,
                              double* bins_re, double* bins_im) {
    for (std::size_t n = 0; n < count; ++n) {
      bins_re[n] -= (next_re[n] * re[n] + next_im[n] * im[n]) / block_size;
      bins_im[n] -= (next_im[n] * re[n] - next_re[n] * im[n]) / block_size;
    }
  };
  less_means(re + 1, im + 1, samples - 1, sums.of(MomentRow::bins_re), sums.of(MomentRow::bins_im));
  if (has_next) {
    less_means(sums.next_re.data(), sums.next_im.data(), samples, sums.of(MomentRow::beams_re),
               sums.of(MomentRow::beams_im));
  }
}

// Means of a block minus the previous means, which Chan's merge needs.
struct Steps {
  std::vector<double> re, im, power;
};

Steps steps_of(const BlockSums& sums, const double* re_sum, const double* im_sum,
               const double* power_sum, double block_size, const std::complex<float>* origin,
               const double* row) {
  const std::size_t samples = sums.next_re.size();
  Steps steps{std::vector<double>(samples), std::vector<double>(samples),
              std::vector<double>(power_sum != nullptr ? samples : 0)};
  for (std::size_t n = 0; n < samples; ++n) {
    const double x0 = origin[n].real(), y0 = origin[n].imag();
    steps.re[n] = (x0 - row[n]) + re_sum[n] / block_size;
    steps.im[n] = (y0 - row[samples + n]) + im_sum[n] / block_size;
    if (power_sum == nullptr) continue;
    steps.power[n] = ((x0 * x0 + y0 * y0) - row[2 * samples + n]) + power_sum[n] / block_size;
  }
  return steps;
}

// row: a beam's moments; next: the offsets of the next beam.
void merge(const BlockSums& sums, const Steps& steps, const Steps* next, double share,
           double weight, double* row) {
  const std::size_t samples = sums.next_re.size();
  const auto at = [&](MomentRow moment) {
    return row + static_cast<std::size_t>(moment) * samples;
  };
  constexpr auto kFirstSum = static_cast<std::size_t>(MomentRow::spread);
  for (std::size_t i = kFirstSum * samples; i < sums.values.size(); ++i) row[i] += sums.values[i];
  for (std::size_t n = 0; n < samples; ++n) {
    const double x = steps.re[n], y = steps.im[n];
    at(MomentRow::mean_re)[n] += share * x;
    at(MomentRow::mean_im)[n] += share * y;
    at(MomentRow::mean_power)[n] += share * steps.power[n];
    at(MomentRow::spread)[n] += weight * (x * x + y * y);
    at(MomentRow::power_spread)[n] += weight * (steps.power[n] * steps.power[n]);
  }
  const auto add = [&](const double* re, const double* im, std::size_t count, MomentRow to_re,
                       MomentRow to_im) {
    for (std::size_t n = 0; n < count; ++n) {
      at(to_re)[n] += weight * (re[n] * steps.re[n] + im[n] * steps.im[n]);
      at(to_im)[n] += weight * (im[n] * steps.re[n] - re[n] * steps.im[n]);
    }
  };
  add(steps.re.data() + 1, steps.im.data() + 1, samples - 1, MomentRow::bins_re,
      MomentRow::bins_im);
  if (next == nullptr) return;
  add(next->re.data(), next->im.data(), samples, MomentRow::beams_re, MomentRow::beams_im);
}

}  // namespace

void add_block(SeriesBlock block, std::uint64_t count, int first, int last, Moments& moments) {
  ENSONIFY_ASSERT(!block.empty() && moments.samples > 0);
  const auto size = static_cast<double>(block.size()), before = static_cast<double>(count);
  const double share = size / (before + size), weight = before * share;
  const auto samples = static_cast<std::size_t>(moments.samples);
  for (int beam = first; beam < last; ++beam) {
    const bool has_next = beam + 1 < moments.beams;
    BlockSums sums = sums_of(block, beam, has_next, moments.samples);
    centre(size, has_next, sums);
    double* const row =
        moments.values.data() + static_cast<std::size_t>(beam) * moments.row_values();
    const std::complex<float>* const origin =
        block[0].data() + static_cast<std::size_t>(beam) * samples;
    const Steps steps = steps_of(sums, sums.of(MomentRow::mean_re), sums.of(MomentRow::mean_im),
                                 sums.of(MomentRow::mean_power), size, origin, row);
    if (!has_next) {
      merge(sums, steps, nullptr, share, weight, row);
      continue;
    }
    const Steps next = steps_of(sums, sums.next_re.data(), sums.next_im.data(), nullptr, size,
                                origin + samples, row + moments.row_values());
    merge(sums, steps, &next, share, weight, row);
  }
}

Ratios ratios(double mean_power, double power_spread, std::uint64_t n) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(n);
  Ratios result{n > 1 ? power_spread / (count - 1) : kNone, kNone, kNone};
  if (!(mean_power > 0)) return result;
  result.contrast = std::sqrt(result.power_variance) / mean_power;
  result.fourth_moment = 1 + power_spread / count / (mean_power * mean_power);
  return result;
}

}  // namespace ensonify
