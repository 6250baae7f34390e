#include "compare/jackknife.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"

namespace ensonify {
namespace {

constexpr std::size_t kPermutations = 1999;
constexpr double kLevelOfTest = 0.05;
constexpr double kLeastVariance = 0.1;  // of the median

// The continued fraction of the incomplete beta function, by Lentz's method (Numerical Recipes,
// 6.4).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300, kEnough = 1e-14;
  const auto away = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1, d = 1 / away(1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m < 1000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away(1 + even * d);
    c = away(1 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away(1 + odd * d);
    c = away(1 + odd / c);
    h *= d * c;
    if (std::abs(d * c - 1) < kEnough) break;
  }
  return h;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a
                                   : 1 - front * beta_fraction(b, a, 1 - x) / b;
}

// P(T > t), t >= 0.
double t_tail(double t, double freedom) {
  return 0.5 * incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t));
}

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

double weighted_rms(const Table& table, const std::vector<double>& weights,
                    const std::vector<std::size_t>& order, std::size_t first) {
  double sum = 0, weight = 0;
  for (std::size_t k = 0; k < table.size(); ++k) {
    double a = 0, b = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      (i < first ? a : b) += table[k][order[i]];
    }
    const double difference = a / static_cast<double>(first) -
                              b / static_cast<double>(order.size() - first);
    sum += weights[k] * difference * difference;
    weight += weights[k];
  }
  return weight > 0 ? std::sqrt(sum / weight) : 0;
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
  if (q < 0.5) return -t_quantile(1 - q, freedom);
  double low = 0, high = 1;
  while (t_tail(high, freedom) > 1 - q && high < 1e300) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = (low + high) / 2;
    (t_tail(middle, freedom) > 1 - q ? low : high) = middle;
  }
  return (low + high) / 2;
}

Interval difference_of(const Estimate& a, const Estimate& b) {
  ENSONIFY_ASSERT(!a.value.empty() && !b.value.empty());
  const double va = a.error[0] * a.error[0], vb = b.error[0] * b.error[0];
  const double error = std::sqrt(va + vb);
  const double difference = a.value[0] - b.value[0];
  if (!(error > 0)) return {difference, error, difference, difference};
  const double freedom = (va + vb) * (va + vb) /
                         (va * va / static_cast<double>(a.blocks() - 1) +
                          vb * vb / static_cast<double>(b.blocks() - 1));
  const double half = t_quantile(1 - kLevelOfTest / 2, freedom) * error;
  return {difference, error, difference - half, difference + half};
}

std::optional<CurveTest> test_curves(const Estimate& a, const Estimate& b, bool free_constant,
                                     std::uint64_t seed) {
  Table table = joined_pseudo(a, b);
  if (table.size() < 2) return std::nullopt;
  if (free_constant) center(table);
  const std::vector<double> weights = weights_of(table);
  std::vector<std::size_t> order(table.front().size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  CurveTest test;
  test.rms = weighted_rms(table, weights, order, a.blocks());
  const std::uint64_t key = mix64(mix64(seed) ^ name_key("permutations"));
  std::vector<double> others;
  std::size_t as_large = 1;
  for (std::size_t turn = 0; turn < kPermutations; ++turn) {
    shuffle_blocks(order, key, static_cast<std::uint32_t>(turn));
    others.push_back(weighted_rms(table, weights, order, a.blocks()));
    if (others.back() >= test.rms) ++as_large;
  }
  std::sort(others.begin(), others.end());
  test.limit = others[static_cast<std::size_t>((1 - kLevelOfTest) * kPermutations)];
  test.share = static_cast<double>(as_large) / (kPermutations + 1);
  return test;
}

}  // namespace ensonify
