#include "compare/jackknife.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/random.h"

namespace ensonify {
namespace {

// By default Boost computes in long double and fills tables for that at every start of the program.
using Double = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

constexpr std::size_t kPermutations = 1999;
constexpr double kLevelOfTest = 0.05;
constexpr double kLeastVariance = 0.1;  // of the median

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double variance_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return values.size() > 1 ? sum / static_cast<double>(values.size() - 1) : 0;
}

// Pseudo-values of all blocks of both, a first: [values][blocks].
using Table = std::vector<std::vector<double>>;

Table joined_pseudo(const Estimate& a, const Estimate& b) {
  Table table;
  for (std::size_t k = 0; k < std::min(a.pseudo.size(), b.pseudo.size()); ++k) {
    if (!std::isfinite(a.error[k]) || !std::isfinite(b.error[k])) continue;
    table.push_back(a.pseudo[k]);
    table.back().insert(table.back().end(), b.pseudo[k].begin(), b.pseudo[k].end());
  }
  return table;
}

// Takes each block's mean over the values from them.
void center(Table& table) {
  for (std::size_t block = 0; block < table.front().size(); ++block) {
    double mean = 0;
    for (const auto& row : table) mean += row[block] / static_cast<double>(table.size());
    for (auto& row : table) row[block] -= mean;
  }
}

// Inverse variances. Values that hardly vary, as the peak of a cut through peaks, must not outweigh
// all others.
std::vector<double> weights_of(const Table& table) {
  std::vector<double> variances;
  for (const auto& row : table) variances.push_back(variance_of(row));
  std::vector<double> sorted = variances;
  std::sort(sorted.begin(), sorted.end());
  const double least = kLeastVariance * sorted[sorted.size() / 2];
  std::vector<double> weights;
  for (const double variance : variances) {
    weights.push_back(least > 0 ? 1 / std::max(variance, least) : 1);
  }
  return weights;
}

// Means of a value over the blocks that stand first in the order, and over the others.
std::pair<double, double> group_means(const std::vector<double>& row,
                                      const std::vector<std::size_t>& order, std::size_t first) {
  double a = 0, b = 0;
  for (std::size_t i = 0; i < order.size(); ++i) (i < first ? a : b) += row[order[i]];
  return {a / static_cast<double>(first), b / static_cast<double>(order.size() - first)};
}

double weighted_rms(const Table& table, const std::vector<double>& weights,
                    const std::vector<std::size_t>& order, std::size_t first) {
  double sum = 0, weight = 0;
  for (std::size_t k = 0; k < table.size(); ++k) {
    const auto [a, b] = group_means(table[k], order, first);
    const double difference = a - b;
    sum += weights[k] * difference * difference;
    weight += weights[k];
  }
  return weight > 0 ? std::sqrt(sum / weight) : 0;
}

// Of a difference(order) of all blocks, which are exchanged at random.
template <class Difference>
CurveTest permuted(std::size_t blocks, std::uint64_t seed, Difference difference) {
  std::vector<std::size_t> order(blocks);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  CurveTest test;
  test.rms = difference(order);
  const std::uint64_t key = mix64(mix64(seed) ^ name_key("permutations"));
  std::vector<double> others;
  std::size_t as_large = 1;
  for (std::size_t turn = 0; turn < kPermutations; ++turn) {
    shuffle_blocks(order, key, static_cast<std::uint32_t>(turn));
    others.push_back(difference(order));
    if (others.back() >= test.rms) ++as_large;
  }
  std::sort(others.begin(), others.end());
  test.limit = others[static_cast<std::size_t>((1 - kLevelOfTest) * kPermutations)];
  test.share = static_cast<double>(as_large) / (kPermutations + 1);
  return test;
}

}  // namespace

void shuffle_blocks(std::vector<std::size_t>& order, std::uint64_t key, std::uint32_t turn) {
  for (std::size_t i = order.size(); i-- > 1;) {
    const auto word = random_words(key, turn, i, 0).v[0];
    std::swap(order[i], order[static_cast<std::size_t>((std::uint64_t{word} * (i + 1)) >> 32)]);
  }
}

Estimate jackknife(const std::vector<double>& all,
                   const std::vector<std::vector<double>>& without) {
  ENSONIFY_ASSERT(without.size() >= 2);
  const auto blocks = static_cast<double>(without.size());
  Estimate estimate;
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<double> pseudo;
    for (const auto& values : without) {
      ENSONIFY_ASSERT(values.size() == all.size());
      pseudo.push_back(blocks * all[k] - (blocks - 1) * values[k]);
    }
    estimate.value.push_back(mean_of(pseudo));
    estimate.error.push_back(std::sqrt(variance_of(pseudo) / blocks));
    estimate.pseudo.push_back(std::move(pseudo));
  }
  return estimate;
}

double t_quantile(double q, double freedom) {
  ENSONIFY_ASSERT(q > 0 && q < 1 && freedom > 0);
  return boost::math::quantile(boost::math::students_t_distribution<double, Double>(freedom), q);
}

double rate_bound(std::uint64_t hits, std::uint64_t trials) {
  if (hits >= trials) return 1;
  return boost::math::ibeta_inv(static_cast<double>(hits + 1), static_cast<double>(trials - hits),
                                0.95, Double());
}

double welch_freedom(double a, double freedom_a, double b, double freedom_b) {
  return (a + b) * (a + b) / (a * a / freedom_a + b * b / freedom_b);
}

DifferenceInterval difference_of(const Estimate& a, const Estimate& b) {
  ENSONIFY_ASSERT(!a.value.empty() && !b.value.empty());
  const double va = a.error[0] * a.error[0], vb = b.error[0] * b.error[0];
  const double error = std::sqrt(va + vb);
  const double difference = a.value[0] - b.value[0];
  if (!(error > 0)) return {difference, error, difference, difference};
  const double freedom = welch_freedom(va, static_cast<double>(a.blocks() - 1), vb,
                                       static_cast<double>(b.blocks() - 1));
  const double half = t_quantile(1 - kLevelOfTest / 2, freedom) * error;
  return {difference, error, difference - half, difference + half};
}

std::optional<CurveTest> test_curves(const Estimate& a, const Estimate& b, bool free_constant,
                                     std::uint64_t seed) {
  Table table = joined_pseudo(a, b);
  if (table.size() < 2) return std::nullopt;
  if (free_constant) center(table);
  const std::vector<double> weights = weights_of(table);
  return permuted(table.front().size(), seed, [&](const std::vector<std::size_t>& order) {
    return weighted_rms(table, weights, order, a.blocks());
  });
}

double distance_of(std::vector<double> p, std::vector<double> q, Distance distance) {
  constexpr double kLeastShare = 1e-6;
  ENSONIFY_ASSERT(p.size() == q.size());
  for (auto* shares : {&p, &q}) {
    double sum = 0;
    for (double& share : *shares) sum += share = std::max(share, 0.0) + kLeastShare;
    for (double& share : *shares) share /= sum;
  }
  double result = 0, moved = 0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    if (distance == Distance::kl) {
      result += p[k] * std::log(p[k] / q[k]);
    } else if (distance == Distance::js) {
      const double middle = (p[k] + q[k]) / 2;
      result += (p[k] * std::log(p[k] / middle) + q[k] * std::log(q[k] / middle)) / 2;
    } else {
      moved += p[k] - q[k];
      result += std::abs(moved);
    }
  }
  return result;
}

std::optional<CurveTest> test_distance(const Estimate& a, const Estimate& b, Distance distance,
                                       std::uint64_t seed) {
  const Table table = joined_pseudo(a, b);
  if (table.size() < 2 || table.size() < a.error.size()) return std::nullopt;
  std::vector<double> p(table.size()), q(table.size());
  return permuted(table.front().size(), seed, [&](const std::vector<std::size_t>& order) {
    for (std::size_t k = 0; k < table.size(); ++k) {
      std::tie(p[k], q[k]) = group_means(table[k], order, a.blocks());
    }
    return distance_of(p, q, distance);
  });
}

}  // namespace ensonify
