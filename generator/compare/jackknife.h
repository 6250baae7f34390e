// Errors from blocks.
//
//   Estimate  jackknife      a value, or several, with pseudo-values by blocks
//   t_quantile  welch_freedom   of Student's distribution
//   rate_bound               upper bound of a probability
//   DifferenceInterval  difference_of  of two estimates of one value
//   CurveTest  test_curves   of two estimates of a curve
//   Distance  test_distance  of two estimates of a histogram
//   shuffle_blocks           a random order
//
// Jackknife over B blocks (Quenouille; Tukey, "Bias and confidence in not quite large samples",
// 1958): with theta from all blocks and theta_b from all but block b, the pseudo-values
// p_b = B theta - (B - 1) theta_b have a mean without the bias of order 1/B, and s^2 / B, of their
// variance s^2, is the mean's squared standard error with B - 1 degrees of freedom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace ensonify {

struct Estimate {
  // Means of the pseudo-values, and their standard errors; NaN where a value is not defined for all
  // blocks but one, whichever it is.
  std::vector<double> value, error;
  std::vector<std::vector<double>> pseudo;  // [values][blocks]

  std::size_t blocks() const { return pseudo.empty() ? 0 : pseudo.front().size(); }
};

// `all` are the values from all blocks, `without[b]` from all but block b. Needs 2 blocks or more
// and equally many values.
Estimate jackknife(const std::vector<double>& all, const std::vector<std::vector<double>>& without);

// The q-quantile for `freedom` > 0 degrees of freedom, which need not be whole; 0 < q < 1.
double t_quantile(double q, double freedom);

// The largest probability at which `hits` or fewer of `trials` occur in one of 20 cases (Clopper
// and Pearson 1934, one-sided); 1 if all are hits.
double rate_bound(std::uint64_t hits, std::uint64_t trials);

// Degrees of freedom of a sum of two squared errors (Welch 1947), of which one is above 0.
double welch_freedom(double a, double freedom_a, double b, double freedom_b);

struct DifferenceInterval {
  double difference = 0, error = 0, low = 0, high = 0;
};

// The first value of a less that of b, with the 95 % interval by welch_freedom of the squared
// errors.
DifferenceInterval difference_of(const Estimate& a, const Estimate& b);

struct CurveTest {
  double rms = 0;    // weighted root mean square of the differences, or the distance
  double limit = 0;  // what it exceeds for 5 % of the permutations
  double share = 1;  // of permutations with as large a difference
};

// A random order, by Fisher and Yates.
void shuffle_blocks(std::vector<std::size_t>& order, std::uint64_t key, std::uint32_t turn);

// Permutation test: if both data sets are alike, their blocks may be exchanged. The differences of
// the mean pseudo-values are weighted by the inverse variance over the blocks of both. The curves
// are centered, so that a constant makes no difference, if `free_constant`. Uses the values
// that are defined in both. None if these are fewer than 2.
std::optional<CurveTest> test_curves(const Estimate& a, const Estimate& b, bool free_constant,
                                     std::uint64_t seed);

// Of shares p and q in K bins, to each of which 1e-6 is added, so that no share is 0:
//   kl   sum p ln(p/q)                                          (Kullback & Leibler 1951)
//   js   (kl(p, m) + kl(q, m)) / 2 with m = (p + q) / 2         (Lin 1991), at most ln 2
//   emd  the mean distance that shares must move, in bins, sum |P - Q| of the cumulative shares
enum class Distance { none, kl, js, emd };
double distance_of(std::vector<double> p, std::vector<double> q, Distance distance);

// The same test for the distance of the mean pseudo-values. None if a share is not defined.
std::optional<CurveTest> test_distance(const Estimate& a, const Estimate& b, Distance distance,
                                       std::uint64_t seed);

}  // namespace ensonify
