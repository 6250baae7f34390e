#include "compare/sum_measures.h"

#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"

namespace ensonify {
namespace {

constexpr double kUncorrelated = 0.05;

}  // namespace

double ratio(double sum, double count, double least) {
  return count >= least ? sum / count : kNone;
}

Values ratios(const Sums::Row& sums, const Sums::Row& counts, double least) {
  Values values;
  for (std::size_t i = 0; i < sums.size(); ++i) values.push_back(ratio(sums[i], counts[i], least));
  return values;
}

double decibels(double intensity) { return intensity > 0 ? 10 * std::log10(intensity) : kNone; }

Values bin_centers(double from, double to, int bins, double scale) {
  Values centers;
  for (int i = 0; i < bins; ++i) centers.push_back((from + (i + 0.5) * (to - from) / bins) * scale);
  return centers;
}

LevelMoments level_moments(std::span<const double> levels) {
  double count = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double level = kLowestLevel + (static_cast<double>(i) + 0.5) * kLevelStep;
    count += levels[i];
    sum += levels[i] * level;
    squares += levels[i] * level * level;
  }
  const double mean = ratio(sum, count);
  return {count, mean, std::sqrt(std::max(0.0, ratio(squares, count) - mean * mean))};
}

double mean_level(const Sums& sums) { return level_moments(sums.levels).mean; }

// Between the levels that occur, linear in their mid-distribution (Ma, Genton and Parzen, Ann.
// Inst. Stat. Math. 63, 2011). Low counts of a recorder are 6 dB apart, and a plain quantile would
// jump from one to the next.
double level_quantile(const Sums::Row& levels, double empty, double q, double lowest, double step) {
  double count = empty;
  for (const double n : levels) count += n;
  const double wanted = q * count;
  if (!(wanted > empty)) return kNone;
  double below = empty, last_middle = 0, last_level = kNone;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!(levels[i] > 0)) continue;
    const double middle = below + levels[i] / 2;
    const double level = lowest + (static_cast<double>(i) + 0.5) * step;
    if (middle >= wanted) {
      if (std::isnan(last_level)) return level;
      return last_level + (wanted - last_middle) / (middle - last_middle) * (level - last_level);
    }
    below += levels[i];
    last_middle = middle;
    last_level = level;
  }
  return last_level;
}

Values gray_shares(std::span<const double> levels, double empty, double mean) {
  if (!std::isfinite(mean)) return Values(kGrays, kNone);
  Values shares(kGrays, 0);
  shares.front() = empty;
  double count = empty;
  // A step of the table lies in one gray level or across the border of two, since it is smaller.
  const auto at = [](double gray) {
    return static_cast<std::size_t>(std::clamp(gray, 0.0, kGrays - 1.0));
  };
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i] == 0) continue;
    const double low = kLowestLevel + static_cast<double>(i) * kLevelStep - mean - kDarkestGray;
    const double over = low + kLevelStep - std::floor(low + kLevelStep);
    const double next = std::min(1.0, over / kLevelStep);
    shares[at(low + kLevelStep)] += next * levels[i];
    shares[at(low)] += (1 - next) * levels[i];
    count += levels[i];
  }
  for (double& share : shares) share = ratio(share, count, kLeastPixels);
  return shares;
}

Values correlations(const Sums::Row& products, const Sums::Row& pairs) {
  Values values;
  for (std::size_t l = 0; l < products.size(); ++l) {
    values.push_back(ratio(products[l], pairs[l], kLeastPixels));
  }
  const double variance = values.empty() ? kNone : values[0];
  for (double& value : values) value /= variance;
  return values;
}

double at_lag(const Values& correlation, double lag) {
  const auto whole = static_cast<std::size_t>(lag);
  if (whole + 1 >= correlation.size()) {
    return whole < correlation.size() && lag == std::floor(lag) ? correlation[whole] : kNone;
  }
  const double part = lag - std::floor(lag);
  return (1 - part) * correlation[whole] + part * correlation[whole + 1];
}

Values at_steps(const Values& correlation, double step) {
  Values values;
  for (int k = 1; k <= kLags; ++k) values.push_back(at_lag(correlation, k * step));
  return values;
}

double half_lag(const Values& correlation) {
  for (std::size_t l = 1; l < correlation.size(); ++l) {
    if (correlation[l] < 0.5) {
      const double last = correlation[l - 1];
      return static_cast<double>(l) - 1 + (last - 0.5) / (last - correlation[l]);
    }
  }
  return kNone;
}

double cell_of(const Values& correlation, int half) {
  double cell = 1;
  for (std::size_t l = 1; l < correlation.size(); ++l) {
    if (!(correlation[l] > kUncorrelated)) break;
    cell += 2 * correlation[l] * std::max(0.0, 1 - static_cast<double>(l) / (2.0 * half + 1));
  }
  return cell;
}

double inverse_shape(double n, double x0, double x1, double x2) {
  if (x0 < kLeastPixels || !(x1 > 0)) return kNone;
  return x2 * x0 / (x1 * x1) * (n + 1) / (2 * n) - 1;
}

LogMoments log_moments(const Sums& s) {
  if (s.log0 < kLeastPixels) return {};
  const double mean = s.log1 / s.log0;
  const double variance = s.log2 / s.log0 - mean * mean;
  const double third = s.log3 / s.log0 - 3 * mean * s.log2 / s.log0 + 2 * mean * mean * mean;
  if (!(variance > 0)) return {};
  return {std::sqrt(variance), third / (variance * std::sqrt(variance))};
}

double cut_width(const Sums::Row& cut, double count) {
  constexpr double kHalf = -3.0103;
  if (count < kLeastMaxima) return kNone;
  const std::size_t middle = cut.size() / 2;
  double width = 0;
  for (const int side : {-1, 1}) {
    double last = 0;
    std::size_t k = 1;
    while (k <= middle && cut[side < 0 ? middle - k : middle + k] / count >= kHalf) {
      last = cut[side < 0 ? middle - k : middle + k] / count;
      ++k;
    }
    if (k > middle) return kNone;
    const double value = cut[side < 0 ? middle - k : middle + k] / count;
    width += static_cast<double>(k) - 1 + (last - kHalf) / (last - value);
  }
  return width;
}

// (mean I^4)^(1/4) over the lags. The fourth power makes the highest lobe count most; the maximum
// itself would rise with the noise of the cut.
double side_lobe(const Sums::Row& cut, double count, const Sums::Row& all_cut, double all_count) {
  const double width = cut_width(all_cut, all_count);
  if (count < kLeastMaxima || !std::isfinite(width)) return kNone;
  const auto middle = static_cast<double>(cut.size() / 2);
  double sum = 0, lags = 0;
  for (std::size_t k = 0; k < cut.size(); ++k) {
    if (std::abs(static_cast<double>(k) - middle) <= 1.5 * width) continue;
    sum += std::pow(10, 4 * cut[k] / count / 10);
    lags += 1;
  }
  return lags < 2 ? kNone : decibels(sum / lags) / 4;
}

Values cut_levels(const Sums::Row& cut, double count) {
  Values levels;
  for (const double value : cut) levels.push_back(count < kLeastMaxima ? kNone : value / count);
  return levels;
}

double edge_width(const Sums& s) {
  if (s.edges < kLeastEdges) return kNone;
  const auto mean = [&](int from, int to) {
    double sum = 0;
    for (int k = from; k <= to; ++k) sum += s.edge_profile[static_cast<std::size_t>(k + kEdgeHalf)];
    return sum / (to - from + 1);
  };
  const double low = mean(-4, -3), high = mean(4, kEdgeHalf);
  if (!(high > low)) return kNone;
  const auto crossing = [&](double share) {
    const double level = low + share * (high - low);
    for (int k = -2; k <= 4; ++k) {
      const double after = s.edge_profile[static_cast<std::size_t>(k + kEdgeHalf)];
      const double before = s.edge_profile[static_cast<std::size_t>(k - 1 + kEdgeHalf)];
      if (after >= level) return after > before ? k - (after - level) / (after - before) : k;
    }
    return kNone;
  };
  return crossing(0.8) - crossing(0.2);
}

double gain_variance(const Sums::Row& sums, const Sums::Row& counts) {
  double most = 0;
  for (const double count : counts) most = std::max(most, count);
  double sum = 0, used = 0;
  for (std::size_t j = 1; j + 1 < sums.size(); ++j) {
    bool enough = true;
    for (std::size_t i = j - 1; i <= j + 1; ++i) enough = enough && counts[i] > 0.25 * most;
    if (!enough || most < kLeastPixels) continue;
    const double step =
        sums[j] / counts[j] - (sums[j - 1] / counts[j - 1] + sums[j + 1] / counts[j + 1]) / 2;
    sum += step * step / 1.5;
    used += 1;
  }
  return ratio(sum, used, 4);
}

double comb_ripple(const Sums& sums, int period) {
  const std::size_t beams = sums.comb_level.size(), groups = static_cast<std::size_t>(period);
  if (beams < kLeastCombBeams || beams < 2 * groups + 8 || sums.comb_images < 1) return kNone;
  Values means(sums.comb_level);
  for (double& level : means) level /= sums.comb_images;
  const Values flat = flattened(means);
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (std::size_t k = 0; k < groups; ++k) {
    double sum = 0, count = 0;
    for (std::size_t i = k; i < flat.size(); i += groups) {
      sum += flat[i];
      count += 1;
    }
    lowest = std::min(lowest, sum / count);
    highest = std::max(highest, sum / count);
  }
  return highest - lowest;
}

}  // namespace ensonify
