#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/moments.h"

namespace ensonify {
namespace {

// Sums over samples have eight parts, so that they do not depend on the instruction set.
typedef double Parts __attribute__((vector_size(64)));
constexpr std::size_t kParts = 8;

// u and x of one beam in every realization, [count][re, im, x][stride]. Behind the last sample are
// zeros, which a lag along range meets.
struct PooledBeam {
  std::size_t stride;
  std::vector<double> values;
  const double* of(std::size_t realization) const { return &values[3 * realization * stride]; }
};

ENSONIFY_VECTOR_CLONES
void take_pooled(const float* __restrict p, const double* __restrict weight, std::size_t samples,
                 double* __restrict re, double* __restrict im, double* __restrict power) {
  for (std::size_t n = 0; n < samples; ++n) {
    re[n] = p[2 * n] * weight[n];
    im[n] = p[2 * n + 1] * weight[n];
    power[n] = re[n] * re[n] + im[n] * im[n];
  }
}

// Sums of products of u and of x.
struct Products {
  double re, im, power;
};

ENSONIFY_VECTOR_CLONES
Products products(const double* here, const double* other, std::size_t stride,
                  std::size_t samples) {
  const auto get = [](const double* from, Parts& parts) {
    std::memcpy(&parts, from, sizeof parts);
  };
  Parts re{}, im{}, power{};
  for (std::size_t n = 0; n < samples; n += kParts) {
    Parts x, y, i, u, v, k;
    get(here + n, x);
    get(here + stride + n, y);
    get(here + 2 * stride + n, i);
    get(other + n, u);
    get(other + stride + n, v);
    get(other + 2 * stride + n, k);
    re += u * x + v * y;
    im += v * x - u * y;
    power += k * i;
  }
  Products sum{0, 0, 0};
  for (std::size_t part = 0; part < kParts; ++part) {
    sum.re += re[part];
    sum.im += im[part];
    sum.power += power[part];
  }
  return sum;
}

void take(SeriesBlock block, const PooledPixels& pool, int beam, std::size_t samples,
          PooledBeam& to) {
  const std::size_t at = static_cast<std::size_t>(beam) * samples;
  for (std::size_t k = 0; k < block.size(); ++k) {
    double* const out = to.values.data() + 3 * k * to.stride;
    take_pooled(reinterpret_cast<const float*>(block[k].data() + at), pool.weight.data() + at,
                samples, out, out + to.stride, out + 2 * to.stride);
  }
}

void count(const PooledBeam& beam, std::size_t realizations, std::span<const double> weight,
           double* histogram) {
  for (std::size_t k = 0; k < realizations; ++k) {
    const double* const power = beam.of(k) + 2 * beam.stride;
    for (std::size_t n = 0; n < weight.size(); ++n) {
      if (weight[n] == 0) continue;
      const double bin = std::min(power[n] / kHistogramStep, kHistogramBins - 1.0);
      histogram[static_cast<int>(bin)] += 1;
    }
  }
}

// Adds the products of a beam with `other`, `shift` samples later, to a value of bins_re or
// beams_re. The same value of the two rows that follow is `row_size` on.
void add_products(const PooledBeam& here, const PooledBeam& other, std::size_t shift,
                  std::size_t realizations, std::size_t samples, std::size_t row_size,
                  double* sums) {
  for (std::size_t k = 0; k < realizations; ++k) {
    const Products sum = products(here.of(k), other.of(k) + shift, here.stride, samples);
    sums[0] += sum.re;
    sums[row_size] += sum.im;
    sums[2 * row_size] += sum.power;
  }
}

}  // namespace

PooledPixels pool_of(std::vector<double> expected_pa2, double within_db) {
  double highest = 0;
  for (const double value : expected_pa2) highest = std::max(highest, value);
  const double least = highest * std::pow(10.0, -within_db / 10);
  PooledPixels pool{std::move(expected_pa2), {}};
  for (const double value : pool.expected_pa2) {
    pool.weight.push_back(value > 0 && value >= least ? 1 / std::sqrt(value) : 0);
  }
  return pool;
}

void add_pooled(SeriesBlock block, const PooledPixels& pool, int first, int last,
                Moments& moments) {
  const auto samples = static_cast<std::size_t>(moments.samples);
  ENSONIFY_ASSERT(pool.weight.size() == samples * static_cast<std::size_t>(moments.beams));
  const auto lags = static_cast<std::size_t>(moments.lags);
  const std::size_t stride = (samples + lags + 2 * kParts) / kParts * kParts;
  // The beams from here to the last lag, which take turns.
  std::vector<PooledBeam> beams(lags + 1, {stride, std::vector<double>(3 * block.size() * stride)});
  const auto beam_at = [&](int beam) -> PooledBeam& {
    return beams[static_cast<std::size_t>(beam) % (lags + 1)];
  };
  int taken = first;
  for (int beam = first; beam < last; ++beam) {
    for (; taken < moments.beams && taken <= beam + moments.lags; ++taken) {
      take(block, pool, taken, samples, beam_at(taken));
    }
    const PooledBeam& here = beam_at(beam);
    double* const row = moments.values.data() +
                        static_cast<std::size_t>(beam) * moments.row_values() +
                        std::size_t(kMoments) * samples;
    count(here, block.size(),
          std::span(pool.weight).subspan(static_cast<std::size_t>(beam) * samples, samples), row);
    if (lags == 0) continue;
    double* const bins = row + kHistogramBins;
    double* const others = bins + 3 * (lags + 1);
    for (std::size_t lag = 0; lag <= lags; ++lag) {
      add_products(here, here, lag, block.size(), samples, lags + 1, bins + lag);
      const int other = beam + static_cast<int>(lag);
      if (other >= moments.beams) continue;
      add_products(here, beam_at(other), 0, block.size(), samples, lags + 1, others + lag);
    }
  }
}

}  // namespace ensonify
