// The search on simulations whose answer is known.
#include "fit/search.h"

#include <cmath>
#include <map>

#include "catch.h"
#include "core/random.h"
#include "results.h"

using namespace ensonify;

namespace {

constexpr int kBlocks = 16;

// Independent normal numbers of a recording (`draw`), block and noise source.
double normal(std::uint32_t draw, int block, int source) {
  return std::sqrt(2.0) *
         complex_normal(99, draw, (std::uint64_t(block) << 32) | std::uint32_t(source), 0).re;
}

// A world with moments f_i(keys) + noise, whose noise has 3 sources that the moments share.
struct World {
  std::vector<double> (*moments)(std::span<const double>);
  double noise = 0.1;

  // Blocks of a recording: mean, error and the blocks themselves as pseudo-values.
  MomentSample sample(std::span<const double> keys, std::uint32_t draw) const {
    const std::vector<double> exact = moments(keys);
    MomentSample sample;
    for (std::size_t m = 0; m < exact.size(); ++m) {
      std::vector<double> blocks;
      double sum = 0, square = 0;
      for (int b = 0; b < kBlocks; ++b) {
        const double e = normal(draw, b, int(m % 3)) + 0.3 * normal(draw, b, 10 + int(m));
        blocks.push_back(exact[m] + noise * e);
        sum += blocks.back();
      }
      const double mean = sum / kBlocks;
      for (const double b : blocks) square += (b - mean) * (b - mean);
      sample.value.push_back(mean);
      sample.error.push_back(std::sqrt(square / (kBlocks * (kBlocks - 1))));
      sample.pseudo.push_back(std::move(blocks));
    }
    return sample;
  }
};

std::vector<double> curved(std::span<const double> k) {
  std::vector<double> moments;
  for (int i = 0; i < 8; ++i) {
    moments.push_back(k[0] * std::exp(-0.3 * i / k[1]) + 0.2 * i * std::log(k[1]));
  }
  moments.push_back(k[0] * k[0]);
  return moments;
}

std::vector<double> blind_to_second(std::span<const double> k) {
  return {k[0], 2 * k[0], k[0] * k[0], 1};
}

std::vector<double> often_undefined(std::span<const double> k) {
  std::vector<double> moments = curved(k);
  moments.push_back(std::nan(""));
  moments.push_back(k[0] > 4 ? std::nan("") : k[0]);
  return moments;
}

Simulate simulator(const World& world, std::uint32_t draw) {
  return [=](std::span<const double> keys) -> Result<MomentSample> {
    return world.sample(keys, draw);
  };
}

const std::vector<FitKey> kKeys = {{"a", 0.5, 5, false}, {"b", 0.2, 20, true}};

}  // namespace

TEST_CASE("places in a range and their values") {
  for (const FitKey& key : kKeys) {
    CHECK(key_value(key, 0) == Approx(key.low));
    CHECK(key_value(key, 1) == Approx(key.high));
  }
  CHECK(key_value(kKeys[0], 0.3) == Approx(1.85));
  CHECK(key_value(kKeys[1], 0.5) == Approx(2));
}

// Protects the search: without noise of its own it finds the keys of a curved model.
TEST_CASE("the fit of an exact recording is exact") {
  const World world{curved, 1e-5};
  const std::vector<double> truth = {2.3, 1.7};
  const auto fit = value_of(fit_keys(kKeys, world.sample(truth, 1), {}, simulator(world, 1)));
  CHECK(fit.keys[0].value == Approx(2.3).epsilon(1e-3));
  CHECK(fit.keys[1].value == Approx(1.7).epsilon(1e-3));
  CHECK(fit.converged);
}

// Protects the intervals: 95 % of them hold the truth, whatever the correlation of the moments.
TEST_CASE("intervals hold the truth as often as they say") {
  const World world{curved};
  constexpr int kDraws = 150;
  int held[2] = {0, 0}, identified = 0;
  double longest = 0;
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    const std::vector<double> truth = {1 + 3 * uniform(5, draw, 0, 0),
                                       0.5 * std::pow(20.0, uniform(5, draw, 1, 0))};
    const FitSettings settings{.profiles = false};
    const auto fit = value_of(fit_keys(kKeys, world.sample(truth, 2 * draw + 2), settings,
                                       simulator(world, 2 * draw + 3)));
    for (int k = 0; k < 2; ++k) {
      held[k] += fit.keys[k].low <= truth[k] && truth[k] <= fit.keys[k].high;
      identified += fit.keys[k].identified;
    }
    longest = std::max(longest, double(fit.evaluations));
  }
  INFO(held[0] << " " << held[1] << " of " << kDraws << ", evaluations " << longest);
  // Three standard errors of a share of 0.95.
  const double margin = 3 * std::sqrt(0.95 * 0.05 / kDraws);
  for (const int count : held) {
    CHECK(double(count) / kDraws > 0.95 - margin);
    CHECK(double(count) / kDraws < 1);
  }
  CHECK(identified > 1.8 * kDraws);
  CHECK(longest < 150);
}

TEST_CASE("a key that no statistic depends on is not identified") {
  const World world{blind_to_second};
  const std::vector<double> truth = {2, 3};
  const auto fit = value_of(fit_keys(kKeys, world.sample(truth, 4), {}, simulator(world, 5)));
  CHECK(fit.keys[0].identified);
  CHECK_FALSE(fit.keys[1].identified);
  CHECK(fit.keys[0].value == Approx(2).margin(0.2));
}

// Protects the scale of profiles: f standard errors away the deviance is f^2.
TEST_CASE("a profile is a parabola of the error") {
  const World world{curved, 0.02};
  const std::vector<double> truth = {2.3, 1.7};
  const auto fit = value_of(fit_keys(kKeys, world.sample(truth, 6), {}, simulator(world, 7)));
  for (const FittedKey& key : fit.keys) {
    REQUIRE(key.profile.size() == 7);
    for (std::size_t i = 0; i < 7; ++i) {
      const double f = double(i) - 3;
      CHECK(key.profile[i].deviance == Approx(f * f).margin(1 + 0.3 * f * f));
    }
  }
}

TEST_CASE("statistics that are not defined are left out") {
  const World world{often_undefined};
  const std::vector<double> truth = {2.3, 1.7};
  const auto fit = value_of(fit_keys(kKeys, world.sample(truth, 8), {}, simulator(world, 9)));
  CHECK_FALSE(fit.used[9]);
  CHECK(fit.used[0]);
  CHECK(fit.keys[0].low < 2.3);
  CHECK(fit.keys[0].high > 2.3);
}

TEST_CASE("errors of a simulation end the fit") {
  const World world{curved};
  int calls = 0;
  const auto fit = fit_keys(kKeys, world.sample(std::vector<double>{2, 2}, 1), {},
                            [&](std::span<const double> keys) -> Result<MomentSample> {
                              if (++calls == 5) return Error{ErrorKind::usage, "no such key"};
                              return world.sample(keys, 1);
                            });
  REQUIRE_FALSE(fit.ok());
  CHECK(fit.error().message == "no such key");
  CHECK(calls == 5);
}
