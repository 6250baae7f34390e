#include "report/speckle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kAboveNoise_db = 15, kBelowHighest_db = 40;
constexpr std::size_t kRowsAside = 2;
constexpr double kGroupBeamWidths = 4;  // breadth of a group of beams

// By instance id; [0] is false.
std::vector<bool> rough_instances(const SequenceFacts& facts) {
  std::vector<bool> rough = {false};
  for (const InstanceFacts& instance : facts.instances) rough.push_back(instance.rough);
  return rough;
}

// Rows that side lobes of something steady may reach.
std::vector<bool> spoilt_rows(const StoredPixels& pixels, const SequenceFacts& facts) {
  const auto rows = static_cast<std::size_t>(pixels.rows);
  const auto columns = static_cast<std::size_t>(pixels.columns);
  std::vector<bool> steady(facts.instances.size() + 1);
  for (std::size_t i = 0; i < facts.instances.size(); ++i) {
    steady[i + 1] = !facts.instances[i].rough && facts.instances[i].kind != "volume";
  }
  std::vector<bool> spoilt(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto begin = pixels.instance.begin() + static_cast<std::ptrdiff_t>(row * columns);
    if (std::none_of(begin, begin + static_cast<std::ptrdiff_t>(columns),
                     [&](std::uint16_t id) { return id < steady.size() && steady[id]; })) {
      continue;
    }
    const std::size_t last = std::min(rows - 1, row + kRowsAside);
    for (std::size_t r = row - std::min(row, kRowsAside); r <= last; ++r) spoilt[r] = true;
  }
  return spoilt;
}

std::size_t group_beams(const ShownSequence& sequence) {
  const auto& azimuth = sequence.facts.azimuth_rad;
  const double spacing =
      azimuth.size() > 1 ? (azimuth.back() - azimuth.front()) / (azimuth.size() - 1.0) : 0;
  if (!(spacing > 0)) return 1;
  const double beams = kGroupBeamWidths * sequence.stored.beam_width_rad / spacing;
  return static_cast<std::size_t>(std::clamp(std::ceil(beams), 1.0, 1e6));
}

void add(double x, PingSpeckle& speckle, std::size_t group) {
  const auto step = static_cast<std::size_t>(x * (kSpeckleSteps / kSpeckleEnd));
  ++speckle.counts[std::min<std::size_t>(step, kSpeckleSteps)];
  SpeckleSum& sum = speckle.groups[group];
  sum.pixels += 1;
  sum.x += x;
  sum.xx += x * x;
}

double contrast_of(const SpeckleSum& sum) {
  const double mean = sum.x / sum.pixels;
  return std::sqrt(std::max(0.0, sum.xx / sum.pixels - mean * mean)) / mean;
}

SpeckleSum total_of(std::span<const SpeckleSum> groups) {
  SpeckleSum total;
  for (const SpeckleSum& group : groups) {
    total.pixels += group.pixels;
    total.x += group.x;
    total.xx += group.xx;
  }
  return total;
}

double standard_error(std::span<const SpeckleSum> groups, const SpeckleSum& total) {
  std::vector<double> without;
  for (const SpeckleSum& group : groups) {
    if (!(group.pixels > 0) || !(group.pixels < total.pixels)) continue;
    without.push_back(
        contrast_of({total.pixels - group.pixels, total.x - group.x, total.xx - group.xx}));
  }
  const auto n = static_cast<double>(without.size());
  double mean = 0, squares = 0;
  for (const double value : without) mean += value / n;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return std::sqrt(squares * (n - 1) / n);
}

}  // namespace

PingSpeckle speckle_of(const StoredPixels& pixels, const ShownSequence& sequence) {
  const SequenceFacts& facts = sequence.facts;
  const bool masks = !pixels.instance.empty();
  const bool all_rough = std::all_of(facts.instances.begin(), facts.instances.end(),
                                     [](const InstanceFacts& i) { return i.rough; });
  if (pixels.level_db.empty() || pixels.clean_db.empty() || (!masks && !all_rough)) return {};
  const auto rows = static_cast<std::size_t>(pixels.rows);
  const auto columns = static_cast<std::size_t>(pixels.columns);
  const float highest_db = *std::max_element(pixels.clean_db.begin(), pixels.clean_db.end());
  const double noise_pa2 = facts.noise_power_pa2;
  const auto least_db = static_cast<float>(
      std::max<double>(level_db(noise_pa2) + kAboveNoise_db, highest_db - kBelowHighest_db));
  const std::vector<bool> rough = rough_instances(facts);
  const std::vector<bool> spoilt = masks ? spoilt_rows(pixels, facts) : std::vector<bool>(rows);
  const std::size_t breadth = group_beams(sequence);
  PingSpeckle speckle;
  speckle.counts.resize(kSpeckleSteps + 1);
  speckle.groups.resize((columns + breadth - 1) / breadth);
  for (std::size_t row = 0; row < rows; ++row) {
    if (spoilt[row]) continue;
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t i = row * columns + column;
      if (!(pixels.clean_db[i] >= least_db)) continue;
      if (masks && (pixels.instance[i] >= rough.size() || !rough[pixels.instance[i]])) continue;
      const double expected_pa2 = mean_square_pa2(pixels.clean_db[i]) + noise_pa2;
      add(mean_square_pa2(pixels.level_db[i]) / expected_pa2, speckle, column / breadth);
    }
  }
  return speckle;
}

std::optional<Speckle> speckle_from(const Survey& survey, std::span<const PingSpeckle> pings) {
  Speckle speckle;
  speckle.counts.resize(kSpeckleSteps);
  // Draws that are the same in every ping of a sequence count as one.
  std::map<std::pair<std::size_t, std::size_t>, SpeckleSum> steady;
  std::vector<SpeckleSum> groups;
  for (std::size_t p = 0; p < pings.size(); ++p) {
    if (!(total_of(pings[p].groups).pixels > 0)) continue;
    ++speckle.pings;
    for (int i = 0; i < kSpeckleSteps; ++i) speckle.counts[i] += pings[p].counts[i];
    speckle.over += pings[p].counts[kSpeckleSteps];
    const std::size_t place = survey.shown[p].sequence;
    if (survey.sequences[place].facts.fresh_speckle) {
      groups.insert(groups.end(), pings[p].groups.begin(), pings[p].groups.end());
      continue;
    }
    for (std::size_t g = 0; g < pings[p].groups.size(); ++g) {
      SpeckleSum& sum = steady[{place, g}];
      sum = total_of(std::vector<SpeckleSum>{sum, pings[p].groups[g]});
    }
  }
  for (const auto& [key, sum] : steady) groups.push_back(sum);
  const SpeckleSum total = total_of(groups);
  if (!(total.x > 0)) return std::nullopt;
  speckle.pixels = static_cast<std::uint64_t>(total.pixels);
  speckle.mean = total.x / total.pixels;
  speckle.contrast = contrast_of(total);
  speckle.contrast_standard_error = standard_error(groups, total);
  return speckle;
}

}  // namespace ensonify
