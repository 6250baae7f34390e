// What is measured, on speckle whose statistics are known.
#include "compare/measure_blocks.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "compare/compare.h"
#include "compare/statistics.h"
#include "core/units.h"
#include "speckle.h"

namespace ensonify {
namespace {

using test::speckle_pings;
using test::SpeckleSpec;

BlockStatistics measured(const PolarPings& pings, int threads = 2) {
  const Workers workers(threads);
  return measure_pings(pings, common_settings(pings, pings, workers), workers);
}

struct Value {
  double value = 0, error = 0;
};

std::vector<Value> values_of(const BlockStatistics& statistics_of_data, const std::string& id) {
  const auto estimates = estimates_of(statistics_of_data);
  for (std::size_t i = 0; i < statistics().size(); ++i) {
    if (statistics()[i].id != id) continue;
    std::vector<Value> values;
    for (std::size_t k = 0; k < estimates[i].value.size(); ++k) {
      values.push_back({estimates[i].value[k], estimates[i].error[k]});
    }
    return values;
  }
  FAIL("no statistic " << id);
  return {};
}

Value value_of(const BlockStatistics& statistics_of_data, const std::string& id) {
  return values_of(statistics_of_data, id).at(0);
}

// Within 4 standard errors, which are no larger than `most`.
void check(const Value& value, double truth, double most) {
  INFO(value.value << " +- " << value.error << ", expected " << truth);
  CHECK(value.error < most);
  CHECK(std::abs(value.value - truth) < 4 * value.error);
}

}  // namespace

// Protects widths in degrees: logs round the azimuths of their beams, so that steps alternate.
TEST_CASE("rounded azimuths keep the step of the grid") {
  PolarPings pings = speckle_pings({});
  const double step = degrees(pings.azimuth_rad[1] - pings.azimuth_rad[0]);
  const double exact = degrees(pings.azimuth_rad.back() - pings.azimuth_rad.front()) /
                       (pings.beams() - 1);
  CHECK(step == Approx(exact));
  const double tick = step / 2.7;  // of three steps, one is of 2 ticks and two are of 3
  for (double& azimuth : pings.azimuth_rad) {
    azimuth = radians(tick * std::round(degrees(azimuth) / tick));
  }
  CHECK(degrees(measured(pings).azimuth_step) == Approx(exact).epsilon(1.0 / pings.beams()));
}

// Protects --pings: it is the largest number, whatever the number of blocks.
TEST_CASE("no more pings are taken than asked for") {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> one = {{0, 100}};
  for (const int images : {2, 5, 10, 37}) {
    std::size_t taken = 0;
    for (const PingRun& run : ping_runs(one, {images, 0})) taken += run.count;
    CHECK(taken <= static_cast<std::size_t>(images));
    CHECK(taken + 10 > static_cast<std::size_t>(images));
  }
}

TEST_CASE("Rayleigh speckle has the moments of theory", "[compare]") {
  const BlockStatistics m = measured(speckle_pings({}));
  check(value_of(m, "inverse_shape"), 0, 0.02);
  // Of the level 10 log10 of an exponential: 10/ln 10 times pi/sqrt 6, and the skewness of the
  // Gumbel distribution. The mean of the window, of 425 pixels, varies by 0.2 dB, which adds
  // 0.004 dB to the spread less what it shares with the pixel.
  const Value spread = value_of(m, "level_spread");
  CHECK(std::abs(spread.value - 5.5701) < 4 * spread.error + 0.01);
  const Value skewness = value_of(m, "level_skewness");
  CHECK(std::abs(skewness.value + 1.1395) < 4 * skewness.error + 0.01);
  CHECK(effective_pixels(m, m.all) == Approx(425));
}

TEST_CASE("a gamma factor gives a K distribution of its shape", "[figure]") {
  SpeckleSpec spec;
  spec.shape = 4;
  const Value value = value_of(measured(speckle_pings(spec)), "inverse_shape");
  check(value, 0.25, 0.03);
}

TEST_CASE("speckle that is summed over samples is correlated as theory has it", "[figure]") {
  SpeckleSpec spec;
  spec.smoothing = 4;
  const BlockStatistics m = measured(speckle_pings(spec));
  const auto range = values_of(m, "range_correlation"),
             azimuth = values_of(m, "azimuth_correlation");
  for (int lag = 1; lag <= 4; ++lag) {
    // |1 - lag/4|^2; the window, of about 150 effective pixels, takes its share of it.
    const double truth = std::pow(std::max(0.0, 1 - lag / 4.0), 2);
    const Value value = range[static_cast<std::size_t>(lag - 1)];
    CHECK(std::abs(value.value - truth) < 4 * value.error + 0.01);
  }
  CHECK(std::abs(azimuth[0].value) < 4 * azimuth[0].error + 0.01);
  // 1 + 2 (9/16 + 4/16 + 1/16) = 2.75 samples a cell, less the taper of the window.
  CHECK(effective_pixels(m, m.all) == Approx(425 / 2.75).epsilon(0.06));
  // The moments are those of fully developed speckle whatever the correlation is.
  check(value_of(m, "inverse_shape"), 0, 0.04);
}

// Levels rise by 12 dB over the samples, so that this, and not chance, decides which patches are
// bright enough: among patches of one mean level those with few nulls have the highest means, and
// their spread is 0.1 dB smaller. A patch of 768 pixels has lost 3 numbers to its plane, and the
// skewness of so few pixels is a little nearer to 0: by up to 0.03 dB and 0.05.
TEST_CASE("plain patches have the moments and correlations of their speckle", "[figure]") {
  SpeckleSpec spec;
  spec.gain = [](int, int r, int) { return std::pow(10, 0.6 * r / 160); };
  const BlockStatistics rayleigh = measured(speckle_pings(spec));
  CHECK(value_of(rayleigh, "plain_spread").value == Approx(5.570).margin(0.05));
  CHECK(value_of(rayleigh, "plain_skewness").value == Approx(-1.140).margin(0.08));
  CHECK(value_of(rayleigh, "plain_beams").value == Approx(0).margin(0.01));
  CHECK(value_of(rayleigh, "plain_samples").value == Approx(0).margin(0.01));
  // Of a K distribution of shape 4: variances psi_1(1) + psi_1(4) of the logarithms, and likewise
  // psi_2.
  spec.shape = 4;
  const BlockStatistics k = measured(speckle_pings(spec));
  CHECK(value_of(k, "plain_spread").value == Approx(6.031).margin(0.06));
  CHECK(value_of(k, "plain_skewness").value == Approx(-0.927).margin(0.08));
  // Amplitudes of Rayleigh speckle whose coherence is 3/4 from sample to sample: pi/4 (F - 1) /
  // (1 - pi/4) with F = 1 + c^2/4 + c^4/64 + c^6/256 + ...
  spec.shape = 0;
  spec.smoothing = 4;
  const BlockStatistics smooth = measured(speckle_pings(spec));
  CHECK(value_of(smooth, "plain_samples").value == Approx(0.536).margin(0.03));
  CHECK(value_of(smooth, "plain_beams").value == Approx(0).margin(0.02));
}

TEST_CASE("a step in a patch makes it no plain one", "[compare]") {
  SpeckleSpec spec;
  spec.gain = [](int, int r, int) { return r % 16 < 8 ? 2.0 : 1.0; };  // 6 dB
  CHECK_FALSE(std::isfinite(value_of(measured(speckle_pings(spec)), "plain_spread").value));
}

TEST_CASE("beams that fire together show a comb", "[figure]") {
  SpeckleSpec spec;
  spec.beams = 96;
  const BlockStatistics none = measured(speckle_pings(spec));
  // Beam means of 24 x 160 pixels of 5.57 dB vary by 0.09 dB, those of 11 beams by 0.027 dB.
  CHECK(value_of(none, "comb_level").value < 0.2);
  CHECK(value_of(none, "comb_share").value < 10);
  // Of 6 dB, the smoothing over the beams keeps the mean of the group alone.
  spec.gain = [](int, int, int c) { return c % 8 == 3 ? std::pow(10, 6.0 / 20) : 1.0; };
  const BlockStatistics comb = measured(speckle_pings(spec));
  CHECK(value_of(comb, "comb_level").value == Approx(6).margin(0.2));
  CHECK(value_of(comb, "comb_share").value == 100);
  // Another period does not show.
  spec.gain = [](int, int, int c) { return c % 7 == 3 ? std::pow(10, 6.0 / 20) : 1.0; };
  CHECK(value_of(measured(speckle_pings(spec)), "comb_share").value == 0);
}

TEST_CASE("classes of pixels are measured apart", "[compare]") {
  SpeckleSpec spec;
  const auto class_at = [](int r, int c) {
    if (c < 12 || c >= 24) return PixelClass::background;
    return r < 80 ? PixelClass::object : PixelClass::shadow;
  };
  spec.gain = [&](int, int r, int c) {
    const PixelClass which = class_at(r, c);
    return which == PixelClass::object ? 10.0 : which == PixelClass::shadow ? 0.1 : 1.0;
  };
  PolarPings pings = speckle_pings(spec);
  for (std::size_t p = 0; p < pings.amplitude.size(); ++p) {
    std::vector<std::uint8_t> classes;
    for (int i = 0; i < spec.samples * spec.beams; ++i) {
      classes.push_back(static_cast<std::uint8_t>(class_at(i / spec.beams, i % spec.beams)));
    }
    pings.classes.push_back(std::move(classes));
  }
  const BlockStatistics m = measured(pings);
  for (const char* which : {"object", "shadow"}) {
    INFO(which);
    CHECK(value_of(m, which + std::string("_share")).value == Approx(12.5));
    // 24 x 960 pixels of 5.57 dB: 0.04 dB.
    CHECK(value_of(m, which + std::string("_spread")).value == Approx(5.57).margin(0.15));
  }
  CHECK(value_of(m, "object_level").value == Approx(20).margin(0.15));
  CHECK(value_of(m, "shadow_level").value == Approx(-20).margin(0.15));
  const Workers workers(2);
  const auto compared = [&](const PolarPings& other) {
    const MeasureSettings settings = common_settings(pings, other, workers);
    return compare_statistics(measure_pings(pings, settings, workers),
                              measure_pings(other, settings, workers), 0, workers);
  };
  PolarPings weaker = pings;
  for (std::size_t p = 0; p < weaker.amplitude.size(); ++p) {
    for (std::size_t i = 0; i < weaker.amplitude[p].size(); ++i) {
      if (weaker.classes[p][i] == 1) weaker.amplitude[p][i] /= 2;
    }
  }
  for (const ComparedStatistic& s : compared(weaker).statistics) {
    INFO(s.id);
    // All levels of objects move by 6.02 dB.
    if (s.id == "object_emd") CHECK(s.difference == Approx(6.02).margin(0.02));
    if (s.id == "object_emd" || s.id == "object_level") CHECK(s.verdict == Verdict::differs);
    if (s.id == "shadow_emd" || s.id == "background_emd") CHECK(s.difference < 0.001);
  }
  weaker.classes.clear();
  for (const ComparedStatistic& s : compared(weaker).statistics) {
    if (s.id.starts_with("object_")) CHECK(s.reason == "too few pixels of the class");
  }
}

TEST_CASE("a peak has its width and side lobes", "[compare]") {
  SpeckleSpec spec;
  const double sigma = 1.5;  // of the amplitude, in samples and beams
  PolarPings pings = speckle_pings(spec);
  for (std::size_t p = 0; p < pings.amplitude.size(); ++p) {
    for (int r = 0; r < spec.samples; ++r) {
      for (int c = 0; c < spec.beams; ++c) {
        const double d2 = std::pow(r - 80, 2) + std::pow(c - 24, 2);
        float& a = pings.amplitude[p][static_cast<std::size_t>(r * spec.beams + c)];
        a = static_cast<float>(1000 * std::exp(-d2 / (2 * sigma * sigma))) + 0.1f * a;
        if ((r == 80 && c == 30) || (c == 24 && r == 89)) a = 50;  // -26 dB
      }
    }
  }
  const BlockStatistics m = measured(pings);
  CHECK(m.all.maxima == static_cast<double>(spec.pings));
  // exp(-d^2/sigma^2) = 1/2 at d = 1.249; linear in dB between the samples at 1 and 2.
  const double at_1 = -10 / std::log(10) / (sigma * sigma), at_2 = 4 * at_1;
  const double width = 2 * (1 + (at_1 + 3.0103) / (at_1 - at_2));
  CHECK(value_of(m, "range_width").value == Approx(width * 50).epsilon(0.001));
  CHECK(value_of(m, "azimuth_width").value == Approx(degrees(width * 0.01)).epsilon(0.001));
  // One of the lags beyond 1.5 widths on both sides has -26.02 dB: (I^4/n)^(1/4).
  const double range_lags = 2 * (12 - std::floor(1.5 * width));
  CHECK(value_of(m, "range_side_lobe").value ==
        Approx(-26.02 - 2.5 * std::log10(range_lags)).margin(0.05));
  CHECK(value_of(m, "azimuth_side_lobe").value > -32);
}

TEST_CASE("stripes of beams have their variance", "[figure]") {
  SpeckleSpec spec;
  spec.beams = 96;
  const double stripe_db = 1;
  spec.gain = [&](int, int, int c) {
    const auto item = static_cast<std::uint64_t>(c);
    const double normal =
        std::sqrt(2.0) * complex_normal(stream_key(9, Stream::array, 0), 0, item, 0).re;
    return std::pow(10, normal * stripe_db / 20);
  };
  const BlockStatistics m = measured(speckle_pings(spec));
  const double found = value_of(m, "beam_gains").value;
  CHECK(found > 0.6);  // 96 beams: the variance is 1 +- 0.15
  CHECK(found < 1.5);
  const Value none = value_of(measured(speckle_pings({})), "beam_gains");
  CHECK(std::abs(none.value) < 5 * none.error);
  CHECK(none.value < 0.02);
}

TEST_CASE("a shadow is dark", "[figure]") {
  SpeckleSpec spec;
  // It moves: what is dark in all pings counts as no ground.
  spec.gain = [](int p, int r, int c) {
    return r >= 30 + 4 * p && r < 50 + 4 * p && c >= 12 && c < 36 ? 0.03 : 1.0;
  };
  const BlockStatistics m = measured(speckle_pings(spec));
  const double ground = m.all.dark_of / spec.pings;
  CHECK(ground > 0.9 * spec.samples * spec.beams);
  CHECK(value_of(m, "dark_share").value == Approx(100 * 20 * 24 / ground).epsilon(0.1));
  CHECK(value_of(m, "dark_level").value < -20);
  CHECK(value_of(measured(speckle_pings({})), "dark_share").value < 0.5);
}

TEST_CASE("gain and threads do not matter", "[compare]") {
  SpeckleSpec spec;
  spec.smoothing = 2;
  const PolarPings pings = speckle_pings(spec);
  PolarPings louder = pings;
  for (auto& amplitude : louder.amplitude) {
    for (float& a : amplitude) a *= 64;  // exact in binary
  }
  const BlockStatistics one = measured(pings, 1), two = measured(pings, 2), loud = measured(louder);
  const auto a = estimates_of(one), b = estimates_of(two), c = estimates_of(loud);
  const std::string free_of_gain[] = {
      "inverse_shape", "level_spread", "range_correlation", "dark_share", "azimuth_correlation",
      "noise_floor",   "plain_spread", "plain_skewness",    "comb_level", "pattern_kl"};
  for (std::size_t i = 0; i < statistics().size(); ++i) {
    for (std::size_t k = 0; k < a[i].value.size(); ++k) {
      if (!std::isfinite(a[i].value[k])) continue;
      INFO(statistics()[i].id);
      CHECK(a[i].value[k] == b[i].value[k]);
      if (std::count(std::begin(free_of_gain), std::end(free_of_gain), statistics()[i].id) > 0) {
        CHECK(c[i].value[k] == Approx(a[i].value[k]).margin(0.05));
      }
    }
  }
  const Comparison comparison = compare_statistics(one, loud, 0, Workers(2));
  CHECK(comparison.gain_db == Approx(-36.12).margin(0.3));
}

// Protects fits of recordings with few counts: a plain quantile jumps 6 dB from count 1 to count 2.
TEST_CASE("quantiles of counts follow the gain without jumps", "[figure]") {
  const PolarPings exact = speckle_pings({});
  double last = 0, largest = 0, least = 0, highest = -200;
  for (int step = 0; step <= 20; ++step) {
    const float gain = 8 * std::pow(1.05f, static_cast<float>(step));  // 0.42 dB a step
    PolarPings counts = exact;
    for (auto& image : counts.amplitude) {
      for (float& amplitude : image) amplitude = std::round(gain * amplitude);
    }
    const auto quantiles = values_of(measured(counts), "quantiles");
    const double low = quantiles[1].value;  // 5 %
    if (step > 0) largest = std::max(largest, std::abs(low - last));
    least = std::min(least, low);
    highest = std::max(highest, low);
    last = low;
  }
  INFO("from " << least << " to " << highest);
  CHECK(highest - least > 6);  // it passes more than one count
  CHECK(largest < 1.5);
}

TEST_CASE("equal speckle agrees and another power of the amplitude differs", "[figure]") {
  SpeckleSpec spec, other;
  other.seed = 2;
  const PolarPings a = speckle_pings(spec), b = speckle_pings(other);
  other.power = 1.1;
  const PolarPings c = speckle_pings(other);
  const Workers workers(2);
  const auto compared = [&](const PolarPings& x, const PolarPings& y) {
    const MeasureSettings settings = common_settings(x, y, workers);
    return compare_statistics(measure_pings(x, settings, workers),
                              measure_pings(y, settings, workers), 0, workers);
  };
  const Comparison equal = compared(a, b), unequal = compared(a, c);
  int differs = 0;
  for (const ComparedStatistic& s : equal.statistics) differs += s.verdict == Verdict::differs;
  CHECK(differs <= 5);  // of 25, expected 1.3
  REQUIRE(equal.classifier.has_value());
  CHECK(std::abs(equal.classifier->all.value - 0.5) < 4 * equal.classifier->all.error);
  for (const ComparedStatistic& s : unequal.statistics) {
    if (s.id == "level_spread" || s.id == "quantiles" || s.id == "inverse_shape") {
      CHECK(s.verdict == Verdict::differs);
    }
  }
  REQUIRE(unequal.classifier.has_value());
  CHECK(unequal.classifier->all.value > 0.6);
}

// Protects verdicts on what does not vary, such as counts of a recording that is always the same.
TEST_CASE("data sets without scatter agree with themselves", "[compare]") {
  SpeckleSpec spec;
  spec.pings = spec.blocks = 4;
  PolarPings pings = speckle_pings(spec);
  std::fill(pings.amplitude.begin(), pings.amplitude.end(), pings.amplitude.front());
  const BlockStatistics m = measured(pings);
  int exact = 0;
  for (const ComparedStatistic& s : compare_statistics(m, m, 0, Workers(2)).statistics) {
    INFO(s.id);
    CHECK(s.verdict != Verdict::differs);
    exact += s.verdict == Verdict::agrees && s.low == 0 && s.high == 0;
  }
  CHECK(exact > 0);
}

TEST_CASE("crops are measured by their pixels", "[compare]") {
  const auto crops_of = [](std::uint64_t seed) {
    SpeckleSpec spec;
    spec.samples = 64;
    spec.seed = seed;
    const PolarPings pings = speckle_pings(spec);
    Crops crops;
    for (std::size_t p = 0; p < pings.amplitude.size(); ++p) {
      crops.crops.push_back({spec.samples, spec.beams, pings.amplitude[p]});
    }
    crops.block = pings.block;
    return crops;
  };
  const Workers workers(2);
  const BlockStatistics a = measure_crops(crops_of(1), crop_settings(), workers);
  const BlockStatistics b = measure_crops(crops_of(2), crop_settings(), workers);
  check(value_of(a, "inverse_shape"), 0, 0.05);
  const Comparison comparison = compare_statistics(a, b, 0, workers);
  CHECK(comparison.crops);
  for (const ComparedStatistic& s : comparison.statistics) {
    CHECK(s.group != "point spread");
    if (s.id == "range_length") CHECK(s.unit == "pixels");
  }
}

TEST_CASE("blocks share the pings evenly", "[compare]") {
  CHECK(block_sizes(10, 3) == std::vector<std::size_t>{3, 3, 4});
  CHECK(block_sizes(2, 5) == std::vector<std::size_t>{1, 1});
}

}  // namespace ensonify
