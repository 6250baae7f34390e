#include "compare/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/jackknife.h"
#include "compare/statistics.h"
#include "core/error.h"

namespace ensonify {
namespace {

constexpr double kMostLikeness = 0.2;
constexpr double kLikeIntervals = 0.1;  // of ping intervals, relative

bool all_defined(const Estimate& estimate) {
  return !estimate.error.empty() && std::all_of(estimate.error.begin(), estimate.error.end(),
                                                [](double e) { return std::isfinite(e); });
}

bool same_positions(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > 1e-3 * (std::abs(a[i]) + std::abs(b[i])) + 1e-9) return false;
  }
  return true;
}

bool like_intervals(const BlockStatistics& a, const BlockStatistics& b) {
  const double x = a.ping_interval_s, y = b.ping_interval_s;
  return std::abs(x - y) <= kLikeIntervals * std::max(x, y);
}

void judge_value(const Estimate& real, const Estimate& simulated, ComparedStatistic& compared) {
  const DifferenceInterval interval = difference_of(real, simulated);
  compared.difference = interval.difference;
  compared.low = interval.low;
  compared.high = interval.high;
  compared.verdict = interval.low <= 0 && interval.high >= 0 ? Verdict::agrees : Verdict::differs;
}

void judge_curve(const Statistic& statistic, const Estimate& real, const Estimate& simulated,
                 std::uint64_t seed, ComparedStatistic& compared) {
  const auto test = statistic.distance == Distance::none
                        ? test_curves(real, simulated, statistic.free_constant, seed)
                        : test_distance(real, simulated, statistic.distance, seed);
  if (!test) {
    compared.reason = statistic.lacks;
    return;
  }
  compared.difference = test->rms;
  compared.high = test->limit;
  compared.share = test->share;
  compared.verdict = test->rms <= test->limit ? Verdict::agrees : Verdict::differs;
}

// Why the statistic cannot be compared, whatever its values are; empty: it can.
std::string reason_against(const Statistic& statistic, const BlockStatistics& real,
                           const BlockStatistics& simulated, const ComparedStatistic& compared) {
  if (statistic.use != StatisticUse::all && real.settings.crops) return "needs pings";
  if (std::string_view(statistic.id) == "ping_correlation" && !like_intervals(real, simulated)) {
    return fmt::format("pings are {:.3g} s apart in one data set and {:.3g} s in the other",
                       real.ping_interval_s, simulated.ping_interval_s);
  }
  if (compared.is_curve() &&
      !same_positions(compared.real_positions, compared.simulated_positions)) {
    return "the grids differ; see the widths";
  }
  return {};
}

ComparedStatistic compared_of(const Statistic& statistic, const BlockStatistics& real,
                              const BlockStatistics& simulated, const Estimate& a,
                              const Estimate& b, std::uint64_t seed) {
  ComparedStatistic compared;
  compared.group = statistic.group;
  compared.id = statistic.id;
  compared.title = statistic.title;
  const bool is_length = compared.id.ends_with("_length");
  compared.unit = real.settings.crops && is_length ? "pixels" : statistic.unit;
  compared.axis = statistic.axis;
  compared.free_constant = statistic.free_constant;
  compared.is_histogram = statistic.distance != Distance::none;
  compared.real = a.value;
  compared.real_error = a.error;
  compared.simulated = b.value;
  compared.simulated_error = b.error;
  if (statistic.positions != nullptr) {
    compared.real_positions = statistic.positions(real);
    compared.simulated_positions = statistic.positions(simulated);
  }
  compared.reason = reason_against(statistic, real, simulated, compared);
  if (!compared.reason.empty()) return compared;
  if (compared.is_curve()) {
    judge_curve(statistic, a, b, seed, compared);
  } else if (all_defined(a) && all_defined(b)) {
    judge_value(a, b, compared);
  } else {
    compared.reason = statistic.lacks;
  }
  return compared;
}

// Mean over the single values of the correlation of a block's pseudo-value with the next one's, for
// independent blocks -1/B.
double likeness_of_blocks(const std::vector<Estimate>& estimates) {
  double sum = 0, count = 0;
  for (const Estimate& estimate : estimates) {
    if (estimate.value.size() != 1 || !(estimate.error[0] > 0)) continue;
    const std::vector<double>& pseudo = estimate.pseudo[0];
    double products = 0, squares = 0;
    for (std::size_t b = 0; b < pseudo.size(); ++b) {
      const double rest = pseudo[b] - estimate.value[0];
      squares += rest * rest;
      if (b > 0) products += rest * (pseudo[b - 1] - estimate.value[0]);
    }
    sum += products / squares;
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

void note_likeness(const char* which, const std::vector<Estimate>& estimates,
                   std::vector<std::string>& notes) {
  const double likeness = likeness_of_blocks(estimates);
  if (likeness < kMostLikeness) return;
  notes.push_back(fmt::format(
      "{}: consecutive blocks resemble each other (correlation {:.2f}), so that intervals are too "
      "narrow; give fewer --blocks, or more sequences",
      which, likeness));
}

double mean_level_of(const BlockStatistics& measured) {
  double sum = 0, count = 0;
  for (const Sums& block : measured.blocks) {
    for (std::size_t i = 0; i < block.levels.size(); ++i) {
      sum += block.levels[i] * (kLowestLevel + (static_cast<double>(i) + 0.5) * kLevelStep);
      count += block.levels[i];
    }
  }
  return count > 0 ? sum / count : 0;
}

std::vector<double> histogram_of(const BlockStatistics& measured, double mean) {
  std::vector<double> shares(kHistogramTo - kHistogramFrom, 0);
  double count = 0;
  for (const Sums& block : measured.blocks) {
    for (std::size_t i = 0; i < block.levels.size(); ++i) {
      count += block.levels[i];
      const double level = kLowestLevel + (static_cast<double>(i) + 0.5) * kLevelStep - mean;
      const double place = std::floor(level - kHistogramFrom);
      if (place < 0 || place >= static_cast<double>(shares.size())) continue;
      shares[static_cast<std::size_t>(place)] += block.levels[i];
    }
  }
  for (double& share : shares) share /= std::max(1.0, count);
  return shares;
}

}  // namespace

const char* verdict_word(Verdict verdict) {
  return verdict == Verdict::agrees    ? "agrees"
         : verdict == Verdict::differs ? "differs"
                                       : "left out";
}

Comparison compare_statistics(const BlockStatistics& real, const BlockStatistics& simulated,
                              std::uint64_t seed, const Workers& workers) {
  ENSONIFY_ASSERT(real.blocks.size() >= 2 && simulated.blocks.size() >= 2);
  Comparison comparison;
  comparison.real_images = real.images;
  comparison.simulated_images = simulated.images;
  comparison.real_blocks = real.blocks.size();
  comparison.simulated_blocks = simulated.blocks.size();
  comparison.crops = real.settings.crops;
  const double real_level = mean_level_of(real), simulated_level = mean_level_of(simulated);
  comparison.gain_db = real_level - simulated_level;
  comparison.real_histogram = histogram_of(real, real_level);
  comparison.simulated_histogram = histogram_of(simulated, simulated_level);
  const bool has_classes = !real.all.class_levels.empty() || !simulated.all.class_levels.empty();
  const std::vector<Estimate> a = estimates_of(real), b = estimates_of(simulated);
  for (std::size_t i = 0; i < statistics().size(); ++i) {
    const Statistic& statistic = statistics()[i];
    if (statistic.use == StatisticUse::classes && !has_classes) continue;
    if (statistic.use != StatisticUse::all && comparison.crops) continue;
    comparison.statistics.push_back(compared_of(statistic, real, simulated, a[i], b[i], seed));
  }
  note_likeness("real", a, comparison.notes);
  note_likeness("simulated", b, comparison.notes);
  comparison.classifier = classify(real, simulated, seed, workers);
  return comparison;
}

}  // namespace ensonify
