#include "core/moments.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "core/random.h"

using namespace ensonify;

namespace {

// Circular complex normal numbers of unit power; every one of item and realisation its own.
std::complex<double> xi(std::uint32_t realisation, std::uint64_t item) {
  const ComplexDraw draw = complex_normal(stream_key(3, Stream::speckle, 0), realisation, item, 0);
  return {draw.re, draw.im};
}

// In blocks, as Ensemble does it, beams in stripes of two.
Moments moments_of(const std::vector<Series>& all, int beams, int samples) {
  Moments moments(beams, samples);
  for (std::size_t first = 0; first < all.size(); first += kMomentBlock) {
    const SeriesBlock block =
        SeriesBlock(all).subspan(first, std::min<std::size_t>(kMomentBlock, all.size() - first));
    for (int beam = 0; beam < beams; beam += 2) {
      add_block(block, moments.count, beam, std::min(beam + 2, beams), moments);
    }
    moments.count += block.size();
  }
  return moments;
}

// A scene of constant part and speckle: each pixel shares a number with the next sample and one
// with the next beam, so that covariances are known.
std::vector<Series> scene(std::uint32_t realisations, int beams, int samples, double constant) {
  std::vector<Series> all;
  for (std::uint32_t k = 0; k < realisations; ++k) {
    Series series;
    for (int j = 0; j < beams; ++j) {
      for (int n = 0; n < samples; ++n) {
        const auto item = static_cast<std::uint64_t>(1000 * j + n);
        const std::complex<double> own =
            xi(k, item) + xi(k, item + 1) * std::complex(0.0, 0.5) + xi(k, item + 1000) * 0.25;
        series.push_back(std::complex<float>(own + constant));
      }
    }
    all.push_back(std::move(series));
  }
  return all;
}

// Two passes in long double: the definition.
struct Plain {
  std::complex<long double> mean, bins, beams;
  long double mean_power = 0, spread = 0, power_spread = 0, power_skew = 0;
};
Plain plain(const std::vector<Series>& all, int beam, int sample, int beams, int samples) {
  const auto at = [&](const Series& p, int j, int n) {
    return std::complex<long double>(p[static_cast<std::size_t>(j * samples + n)]);
  };
  const auto mean = [&](int j, int n) {
    std::complex<long double> sum = 0;
    for (const Series& p : all) sum += at(p, j, n);
    return sum / static_cast<long double>(all.size());
  };
  Plain result;
  result.mean = mean(beam, sample);
  for (const Series& p : all) result.mean_power += std::norm(at(p, beam, sample));
  result.mean_power /= static_cast<long double>(all.size());
  for (const Series& p : all) {
    const auto own = at(p, beam, sample) - result.mean;
    const long double power = std::norm(at(p, beam, sample)) - result.mean_power;
    result.spread += std::norm(own);
    result.power_spread += power * power;
    result.power_skew += power * power * power;
    if (sample + 1 < samples) {
      result.bins += (at(p, beam, sample + 1) - mean(beam, sample + 1)) * std::conj(own);
    }
    if (beam + 1 < beams) {
      result.beams += (at(p, beam + 1, sample) - mean(beam + 1, sample)) * std::conj(own);
    }
  }
  return result;
}

double value(const Moments& m, MomentRow moment, int beam, int sample) {
  return m.of(moment, beam)[static_cast<std::size_t>(sample)];
}

}  // namespace

// Protects the sums: blocks, merges and stripes against the definition in two passes, also with a
// last block that is short, and of a constant a thousand times the spread, where sums of squares
// would lose six digits.
TEST_CASE("moments in blocks are those of the definition") {
  constexpr int kBeams = 5;
  const int samples = GENERATE(1, 4, 16, 19);  // also more than are summed at once
  const double constant = GENERATE(0.0, 1000.0);
  const std::uint32_t count = GENERATE(2u, 8u, 43u);
  const auto all = scene(count, kBeams, samples, constant);
  const Moments m = moments_of(all, kBeams, samples);
  CHECK(m.count == count);
  const double scale = constant > 0 ? 1e-9 : 1e-12;
  for (int j = 0; j < kBeams; ++j) {
    for (int n = 0; n < samples; ++n) {
      INFO("beam " << j << " sample " << n);
      const Plain p = plain(all, j, n, kBeams, samples);
      const auto close = [&](MomentRow moment, long double expected, double size) {
        CHECK(value(m, moment, j, n) ==
              Approx(static_cast<double>(expected)).margin(scale * size).epsilon(0));
      };
      const auto spread = static_cast<double>(p.spread);
      close(MomentRow::mean_re, p.mean.real(), 1);
      close(MomentRow::mean_im, p.mean.imag(), 1);
      close(MomentRow::mean_power, p.mean_power, static_cast<double>(p.mean_power));
      close(MomentRow::spread, p.spread, spread);
      close(MomentRow::power_spread, p.power_spread, static_cast<double>(p.power_spread));
      // Of nearly symmetric deviations, far less than the sum of their sizes.
      close(MomentRow::power_skew, p.power_skew,
            std::pow(static_cast<double>(p.power_spread), 1.5));
      close(MomentRow::bins_re, p.bins.real(), spread);
      close(MomentRow::bins_im, p.bins.imag(), spread);
      close(MomentRow::beams_re, p.beams.real(), spread);
      close(MomentRow::beams_im, p.beams.imag(), spread);
    }
  }
}

// Protects what a study reads off: speckle has contrast 1, fourth moment 2 and the covariances that
// it was made with. 4,000 realisations at 60 pixels that share little: a pixel's standard error of
// the contrast is 1/sqrt(n), of the fourth moment 2/sqrt(n), so that of the mean over M pixels is
// that over sqrt(M), times the root of the sum of |coherence|^4 over lags, 1.2 here at most.
// Expectations at n are 1 - 1/n, 2n/(n + 1) and 6n^2/((n + 1)(n + 2)). Tolerances are 4 standard
// errors.
TEST_CASE("speckle has contrast 1 and fourth moment 2 within their standard errors") {
  constexpr int kBeams = 6, kSamples = 10;
  constexpr std::uint32_t kCount = 4000;
  const Moments m = moments_of(scene(kCount, kBeams, kSamples, 0), kBeams, kSamples);
  double contrast = 0, fourth = 0, third = 0;
  std::complex<double> bins = 0, beams = 0;
  for (int j = 0; j < kBeams; ++j) {
    for (int n = 0; n < kSamples; ++n) {
      const Ratios r =
          ratios(value(m, MomentRow::mean_power, j, n), value(m, MomentRow::power_spread, j, n),
                 value(m, MomentRow::power_skew, j, n), kCount);
      contrast += r.contrast / (kBeams * kSamples);
      fourth += r.fourth_moment / (kBeams * kSamples);
      third += r.third_moment / (kBeams * kSamples);
      bins += std::complex(value(m, MomentRow::bins_re, j, n), value(m, MomentRow::bins_im, j, n)) /
              (kCount * kBeams * (kSamples - 1.0));
      beams +=
          std::complex(value(m, MomentRow::beams_re, j, n), value(m, MomentRow::beams_im, j, n)) /
          (kCount * kSamples * (kBeams - 1.0));
    }
  }
  const double se = 1.2 / std::sqrt(double(kCount) * kBeams * kSamples);
  CHECK(contrast == Approx(1 - 1.0 / kCount).margin(4 * se));
  CHECK(fourth == Approx(2 - 2.0 / kCount).margin(8 * se));
  CHECK(third == Approx(6 - 18.0 / kCount).margin(4 * std::sqrt(360.0) * se));
  // E p' p*: the next sample's own number is i/2 of this one's; the next beam's a quarter.
  const double power = 1 + 0.25 + 0.0625;
  CHECK(std::abs(bins - std::complex(0.0, -0.5)) < 4 * 1.5 * power * se);
  CHECK(std::abs(beams - 0.25) < 4 * 1.5 * power * se);
}

// Protects scenes with a constant part: contrast^2 = (1 + 2 kappa)/(1 + kappa)^2 of a Rician pixel.
// By the delta method with Rician moments the standard error is under 1/sqrt(n); 12,000
// realisations of 6 independent pixels.
TEST_CASE("a constant part has the contrast of Rice's distribution") {
  const double kappa = GENERATE(0.5, 4.0, 100.0);
  constexpr std::uint32_t kCount = 12000;
  std::vector<Series> all;
  for (std::uint32_t k = 0; k < kCount; ++k) {
    Series series;
    for (int j = 0; j < 6; ++j) {
      series.push_back(std::complex<float>(xi(k, static_cast<std::uint64_t>(j)) +
                                           std::polar(std::sqrt(kappa), 1.0 * j)));
    }
    all.push_back(std::move(series));
  }
  const Moments m = moments_of(all, 6, 1);
  double contrast = 0, kappa_found = 0;
  for (int j = 0; j < 6; ++j) {
    contrast += ratios(value(m, MomentRow::mean_power, j, 0),
                       value(m, MomentRow::power_spread, j, 0), 0, kCount)
                    .contrast /
                6;
    kappa_found += std::norm(std::complex(value(m, MomentRow::mean_re, j, 0),
                                          value(m, MomentRow::mean_im, j, 0))) /
                   (value(m, MomentRow::spread, j, 0) / (kCount - 1.0)) / 6;
  }
  const double expected = std::sqrt(1 + 2 * kappa) / (1 + kappa);
  CHECK(contrast == Approx(expected).margin(4 * expected / std::sqrt(6.0 * kCount)));
  CHECK(kappa_found == Approx(kappa).epsilon(4 * std::sqrt((1 + 2 / kappa) / (6.0 * kCount))));
}

TEST_CASE("ratios are unbiased where they say so, and what has no energy has no contrast") {
  const Ratios six = ratios(2, 30, 48, 6);
  CHECK(six.power_variance == Approx(6).epsilon(1e-15));
  CHECK(six.contrast == Approx(std::sqrt(6.0) / 2).epsilon(1e-15));
  CHECK(six.fourth_moment == Approx(1 + 5.0 / 4).epsilon(1e-15));
  CHECK(six.third_moment == Approx(1 + 3 * 5.0 / 4 + 8.0 / 8).epsilon(1e-15));
  const Ratios none = ratios(0, 0, 0, 100);
  CHECK(std::isnan(none.contrast));
  CHECK(std::isnan(none.fourth_moment));
  CHECK(none.power_variance == 0);
  CHECK(std::isnan(ratios(1, 0, 0, 1).contrast));
}

// Protects histogram and lags: add_pooled in blocks and stripes against plain loops over all pairs,
// with pixels that are left out, lags beyond the last beam, and intensities beyond the last bin.
TEST_CASE("pooled sums are those of all pairs of pooled pixels") {
  constexpr int kBeams = 5, kSamples = 19;
  const int lags = GENERATE(0, 3, 7);
  auto all = scene(21, kBeams, kSamples, 0);
  all[4][3 * kSamples + 2] = {30, 40};
  std::vector<double> expected;
  for (int i = 0; i < kBeams * kSamples; ++i) expected.push_back(1 + (i * 7) % 23);
  const PooledPixels pool = pool_of(expected, 10);  // those from 2.3 on
  Moments m(kBeams, kSamples, lags);
  for (std::size_t first = 0; first < all.size(); first += kMomentBlock) {
    const SeriesBlock block =
        SeriesBlock(all).subspan(first, std::min<std::size_t>(kMomentBlock, all.size() - first));
    for (const int beam : {4, 0, 2}) {
      add_pooled(block, pool, beam, std::min(beam + 2, kBeams), m);
    }
  }
  const auto at = [&](const Series& p, int j, int n) {
    const auto i = static_cast<std::size_t>(j * kSamples + n);
    const bool pooled = j < kBeams && n < kSamples && expected[i] >= 2.3;
    return pooled ? std::complex<double>(p[i]) / std::sqrt(expected[i]) : 0.0;
  };
  for (int j = 0; j < kBeams; ++j) {
    std::vector<double> counts(kHistogramBins);
    for (const Series& p : all) {
      for (int n = 0; n < kSamples; ++n) {
        if (at(p, j, n) == 0.0) continue;
        counts[std::min<std::size_t>(static_cast<std::size_t>(std::norm(at(p, j, n)) * 10), 200)] +=
            1;
      }
    }
    const auto histogram = m.of(PooledRow::histogram, j);
    CHECK(std::equal(histogram.begin(), histogram.end(), counts.begin()));
    for (int lag = 0; lag <= lags && lags > 0; ++lag) {
      std::complex<double> bins, beams;
      double bins_power = 0, beams_power = 0;
      for (const Series& p : all) {
        for (int n = 0; n < kSamples; ++n) {
          const auto here = at(p, j, n), later = at(p, j, n + lag), beside = at(p, j + lag, n);
          bins += later * std::conj(here);
          beams += beside * std::conj(here);
          bins_power += std::norm(later) * std::norm(here);
          beams_power += std::norm(beside) * std::norm(here);
        }
      }
      INFO("beam " << j << " lag " << lag);
      const auto sum = [&](PooledRow row) { return m.of(row, j)[static_cast<std::size_t>(lag)]; };
      CHECK(std::abs(std::complex(sum(PooledRow::bins_re), sum(PooledRow::bins_im)) - bins) < 1e-9);
      CHECK(std::abs(std::complex(sum(PooledRow::beams_re), sum(PooledRow::beams_im)) - beams) <
            1e-9);
      CHECK(sum(PooledRow::bins_power) == Approx(bins_power).epsilon(1e-12));
      CHECK(sum(PooledRow::beams_power) == Approx(beams_power).epsilon(1e-12));
    }
  }
}
