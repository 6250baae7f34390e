#include "fit/moments.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "compare/statistics.h"

namespace ensonify {
namespace {

// A side lobe is measured beyond 1.5 widths of its cut, so that a wider beam loses samples one at a
// time; the cuts hold the same.
bool is_smooth(const Statistic& statistic) {
  return !std::string_view(statistic.id).ends_with("side_lobe");
}

// Subtracts from every block the mean over the values that are defined.
void center(std::vector<std::vector<double>>& pseudo) {
  for (std::size_t b = 0; !pseudo.empty() && b < pseudo.front().size(); ++b) {
    double sum = 0, count = 0;
    for (const auto& value : pseudo) {
      if (std::isnan(value[b])) continue;
      sum += value[b];
      count += 1;
    }
    for (auto& value : pseudo) value[b] -= sum / count;
  }
}

void add_moment(std::vector<double> pseudo, MomentSample& sample) {
  const auto blocks = static_cast<double>(pseudo.size());
  double sum = 0, square = 0;
  for (const double p : pseudo) sum += p;
  const double mean = sum / blocks;
  for (const double p : pseudo) square += (p - mean) * (p - mean);
  sample.value.push_back(mean);
  sample.error.push_back(std::sqrt(square / (blocks * (blocks - 1))));
  sample.pseudo.push_back(std::move(pseudo));
}

}  // namespace

MomentSample moments_of(const BlockStatistics& measured) {
  const std::vector<Estimate> estimates = estimates_of(measured);
  MomentSample sample;
  for (std::size_t s = 0; s < estimates.size(); ++s) {
    const Statistic& statistic = statistics()[s];
    if (!is_smooth(statistic)) continue;
    std::vector<std::vector<double>> pseudo = estimates[s].pseudo;
    if (statistic.positions != nullptr && statistic.free_constant) center(pseudo);
    for (auto& values : pseudo) add_moment(std::move(values), sample);
  }
  return sample;
}

std::vector<std::string> moment_names(const BlockStatistics& measured) {
  std::vector<std::string> names;
  for (const Statistic& statistic : statistics()) {
    if (!is_smooth(statistic)) continue;
    if (statistic.positions == nullptr) {
      names.emplace_back(statistic.id);
      continue;
    }
    for (const double position : statistic.positions(measured)) {
      names.push_back(fmt::format("{} {:.4g}", statistic.id, position));
    }
  }
  return names;
}

}  // namespace ensonify
