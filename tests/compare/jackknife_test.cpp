// Errors from blocks: closed forms, tables, and rates of error of the tests.
#include "compare/jackknife.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/random.h"

namespace ensonify {
namespace {

double normal(std::uint64_t seed, std::uint64_t item) {
  return std::sqrt(2.0) * complex_normal(stream_key(seed, Stream::speckle, 0), 0, item, 0).re;
}

// Blocks whose values are their own means.
Estimate estimate_of_means(const std::vector<std::vector<double>>& blocks) {
  const auto mean_without = [&](std::size_t left_out) {
    std::vector<double> mean(blocks[0].size(), 0);
    double count = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (b == left_out) continue;
      count += 1;
      for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += blocks[b][k];
    }
    for (double& value : mean) value /= count;
    return mean;
  };
  std::vector<std::vector<double>> without;
  for (std::size_t b = 0; b < blocks.size(); ++b) without.push_back(mean_without(b));
  return jackknife(mean_without(blocks.size()), without);
}

std::vector<std::vector<double>> random_blocks(std::uint64_t seed, std::size_t blocks,
                                               std::size_t values, double shift) {
  std::vector<std::vector<double>> all(blocks, std::vector<double>(values));
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::size_t k = 0; k < values; ++k) {
      all[b][k] = normal(seed, b * 1000 + k) + (k == 0 ? shift : 0);
    }
  }
  return all;
}

}  // namespace

TEST_CASE("quantiles of Student's distribution are those of the tables", "[compare]") {
  CHECK(t_quantile(0.975, 1) == Approx(12.7062).epsilon(1e-5));
  CHECK(t_quantile(0.975, 9) == Approx(2.262157).epsilon(1e-6));
  CHECK(t_quantile(0.95, 4) == Approx(2.131847).epsilon(1e-6));
  CHECK(t_quantile(0.975, 1e6) == Approx(1.959966).epsilon(1e-5));
  CHECK(t_quantile(0.025, 9) == Approx(-2.262157).epsilon(1e-6));
  CHECK(t_quantile(0.975, 4.5) > t_quantile(0.975, 5));
}

TEST_CASE("the jackknife of a mean gives its standard error", "[compare]") {
  const Estimate estimate = estimate_of_means({{1}, {2}, {4}, {7}});
  CHECK(estimate.value[0] == Approx(3.5));
  CHECK(estimate.error[0] == Approx(std::sqrt(7.0 / 4)));  // s^2 = 7
}

TEST_CASE("the jackknife takes the bias of a squared mean away", "[compare]") {
  // (mean)^2 of 1, 2, 4, 7 is biased by s^2/B; what is left is exact for a quadratic.
  const std::vector<double> x = {1, 2, 4, 7};
  std::vector<std::vector<double>> without;
  for (const double left_out : x) without.push_back({std::pow((14 - left_out) / 3, 2)});
  const Estimate estimate = jackknife({3.5 * 3.5}, without);
  CHECK(estimate.value[0] == Approx(3.5 * 3.5 - 7.0 / 4));
}

TEST_CASE("an undefined value without a block has no error", "[compare]") {
  const Estimate estimate = jackknife({1.0}, {{1.0}, {std::nan("")}, {2.0}});
  CHECK_FALSE(std::isfinite(estimate.error[0]));
}

TEST_CASE("intervals of differences hold the truth in 95 of 100 cases", "[compare][figure]") {
  int held = 0;
  constexpr int kCases = 1000;
  for (int i = 0; i < kCases; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    auto wide = random_blocks(2 * seed + 1, 6, 1, 0);
    for (auto& block : wide) block[0] *= 3;
    const DifferenceInterval interval = difference_of(
        estimate_of_means(random_blocks(2 * seed, 12, 1, 0)), estimate_of_means(wide));
    held += interval.low <= 0 && interval.high >= 0;
  }
  // The binomial's standard deviation is 6.9 of 1000.
  CHECK(std::abs(held - 950) < 25);
}

TEST_CASE("equal curves differ in 5 of 100 cases, and unequal ones are found",
          "[compare][figure]") {
  int differs = 0, found = 0;
  constexpr int kCases = 200;
  for (int i = 0; i < kCases; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const Estimate a = estimate_of_means(random_blocks(2 * seed, 10, 6, 0));
    const Estimate b = estimate_of_means(random_blocks(2 * seed + 1, 10, 6, 0));
    const Estimate c = estimate_of_means(random_blocks(2 * seed + 1, 10, 6, 3));
    const auto equal = test_curves(a, b, false, 1), unequal = test_curves(a, c, false, 1);
    REQUIRE(equal.has_value());
    REQUIRE(unequal.has_value());
    differs += equal->rms > equal->limit;
    found += unequal->rms > unequal->limit;
  }
  CHECK(std::abs(differs - 10) < 10);  // standard deviation 3.1
  CHECK(found > 0.95 * kCases);
}

TEST_CASE("a constant makes no difference to curves that are free of one", "[compare]") {
  auto shifted = random_blocks(3, 10, 6, 0);
  for (auto& block : shifted) {
    for (double& value : block) value += 20;
  }
  const Estimate a = estimate_of_means(random_blocks(3, 10, 6, 0));
  const Estimate b = estimate_of_means(shifted);
  CHECK(test_curves(a, b, true, 1)->rms < 1e-9);
  CHECK(test_curves(a, b, false, 1)->rms == Approx(20));
}

TEST_CASE("distances of histograms have their closed forms", "[compare]") {
  const std::vector<double> p = {0.5, 0.5, 0}, q = {0.25, 0.75, 0}, r = {0, 0, 1};
  CHECK(distance_of(p, q, Distance::kl) ==
        Approx(0.5 * std::log(2.0) + 0.5 * std::log(2.0 / 3)).margin(1e-5));
  CHECK(distance_of(q, p, Distance::kl) ==
        Approx(0.25 * std::log(0.5) + 0.75 * std::log(1.5)).margin(1e-5));
  CHECK(distance_of(p, r, Distance::js) == Approx(std::log(2.0)).margin(1e-4));
  CHECK(distance_of(p, q, Distance::js) == distance_of(q, p, Distance::js));
  CHECK(distance_of(p, q, Distance::emd) == Approx(0.25).margin(1e-5));
  CHECK(distance_of(q, p, Distance::emd) == Approx(0.25).margin(1e-5));
  CHECK(distance_of(p, r, Distance::emd) == Approx(1.5).margin(1e-5));
  CHECK(distance_of(p, p, Distance::kl) == 0);
}

TEST_CASE("equal histograms agree and moved ones differ", "[compare]") {
  // Shares of 20 numbers a block in 5 bins of a normal distribution.
  const auto blocks = [](std::uint64_t seed, double mean) {
    std::vector<std::vector<double>> shares;
    for (const auto& block : random_blocks(seed, 12, 20, 0)) {
      shares.emplace_back(5, 0.0);
      for (const double v : block) {
        shares.back()[static_cast<std::size_t>(std::clamp((v + mean) / 2 + 2.5, 0.0, 4.0))] += 0.05;
      }
    }
    return shares;
  };
  const Estimate a = estimate_of_means(blocks(1, 0)), b = estimate_of_means(blocks(2, 0)),
                 c = estimate_of_means(blocks(3, 2));
  for (const Distance distance : {Distance::kl, Distance::js, Distance::emd}) {
    const auto equal = test_distance(a, b, distance, 1), moved = test_distance(a, c, distance, 1);
    REQUIRE(equal.has_value());
    REQUIRE(moved.has_value());
    CHECK(equal->rms <= equal->limit);
    CHECK(moved->rms > moved->limit);
    CHECK(moved->share < 0.01);
  }
}

// Protects the number that people plan a night by. Without hits, and with all but one, the bound has
// a closed form.
TEST_CASE("the bound of a rate is that of Clopper and Pearson") {
  for (const std::uint64_t trials : {1u, 20u, 200u}) {
    const double n = static_cast<double>(trials);
    CHECK(std::abs(rate_bound(0, trials) - (1 - std::pow(0.05, 1 / n))) < 1e-9);
    CHECK(std::abs(rate_bound(trials - 1, trials) - std::pow(0.95, 1 / n)) < 1e-9);
    CHECK(rate_bound(trials, trials) == 1);
  }
  CHECK(rate_bound(3, 200) > rate_bound(2, 200));
  CHECK(rate_bound(3, 200) < rate_bound(3, 100));
}

}  // namespace ensonify
