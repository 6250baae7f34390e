#include "report/look.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kSpan_db = 100;  // of codes, below the highest level
constexpr double kShown_db = 60;  // of the first view, at most

const PlaneNames kShownPlanes = {"level_db", "clean_db", "elevation_rad", "instance",
                                 "semantic", "shadow",   "multipath"};

// What one ping adds.
struct PingLook {
  LevelCounts levels;
  double least_rad = 1e9, most_rad = -1e9;
  PingSpeckle speckle;
};

// [beams x samples] -> [samples x beams].
std::vector<float> levels_of(const std::vector<std::complex<float>>& series, std::size_t beams,
                             std::size_t samples) {
  std::vector<float> levels(series.size());
  for (std::size_t beam = 0; beam < beams; ++beam) {
    for (std::size_t sample = 0; sample < samples; ++sample) {
      levels[sample * beams + beam] = image_level_db(std::norm(series[beam * samples + sample]));
    }
  }
  return levels;
}

PingLook look_at_ping(const StoredPixels& pixels, const ShownSequence& sequence) {
  PingLook look;
  look.levels.add(pixels.level_db);
  for (const float db : pixels.clean_db) {
    look.levels.highest_db = std::max(look.levels.highest_db, db);
  }
  for (const float rad : pixels.elevation_rad) {
    if (std::isnan(rad)) continue;
    look.least_rad = std::min<double>(look.least_rad, rad);
    look.most_rad = std::max<double>(look.most_rad, rad);
  }
  look.speckle = speckle_of(pixels, sequence);
  return look;
}

// The level below which this share of all pixels lies.
double level_at(const LevelCounts& levels, double share) {
  std::uint64_t all = 0, below = 0;
  for (const std::uint64_t n : levels.steps) all += n;
  std::size_t i = 0;
  while (i + 1 < levels.steps.size() &&
         static_cast<double>(below) < share * static_cast<double>(all)) {
    below += levels.steps[i++];
  }
  return LevelCounts::kLeastDb + static_cast<double>(i);
}

constexpr double kAboveNoise_db = 15, kBelowHighest_db = 40;
constexpr std::size_t kRowsAside = 2;
constexpr double kGroupBeamWidths = 4;  // breadth of a group of beams

// By instance id; [0] is false.
std::vector<bool> rough_instances(const SequenceFacts& facts) {
  std::vector<bool> rough = {false};
  for (const InstanceFacts& instance : facts.instances) rough.push_back(instance.rough);
  return rough;
}

// Rows that the side lobes of coherent echoes may reach.
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

std::uint8_t grey_code(double value, double low, double high) {
  if (std::isnan(value)) return 0;
  const double code = 1 + 254 * (value - low) / (high - low);
  return static_cast<std::uint8_t>(std::lround(std::clamp(code, 1.0, 255.0)));
}

Result<StoredPixels> pixels_of(const PictureJob& job, const ShownPing& ping) {
  const StoredSequence& sequence = job.survey.sequences[ping.sequence].stored;
  const bool has_level = stored_planes(sequence, ImageView::polar).contains("level_db");
  auto pixels = read_picture(job.dataset, sequence, ImageView::polar, ping.ping, kShownPlanes);
  if (!pixels || has_level || !has_series(sequence)) return pixels;
  const auto series = read_series(job.dataset, sequence, ping.ping);
  if (!series) return series.error();
  pixels->level_db = levels_of(*series, sequence.beams, sequence.samples);
  return pixels;
}

Status for_each_picture(const Workers& workers, bool (*stop)(), std::size_t count,
                        const std::function<Status(std::size_t)>& use) {
  std::vector<Status> states(count);
  std::atomic<bool> stopped = false, failed = false;
  workers.for_each(count, [&](std::size_t i) {
    if (stop != nullptr && stop()) stopped = true;
    if (stopped || failed) return;
    states[i] = use(i);
    if (!states[i]) failed = true;
  });
  for (const Status& state : states) {
    if (!state) return state;
  }
  if (stopped) return Error{ErrorKind::interrupted, "interrupted; the page was not written"};
  return {};
}

void LevelCounts::add(std::span<const float> levels_db) {
  for (const float db : levels_db) {
    if (!(db > kNoEnergyDb)) continue;
    highest_db = std::max(highest_db, db);
    const int step = static_cast<int>(std::floor(db)) - kLeastDb;
    ++steps[static_cast<std::size_t>(std::clamp(step, 0, kSteps - 1))];
  }
}

void LevelCounts::add(const LevelCounts& others) {
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] += others.steps[i];
  highest_db = std::max(highest_db, others.highest_db);
}

PictureScale scale_of(const LevelCounts& levels) {
  PictureScale scale;
  const bool heard = levels.highest_db > kNoEnergyDb;
  scale.max_db = heard ? std::ceil(levels.highest_db) : 140.0;
  scale.min_db = scale.max_db - kSpan_db;
  scale.show_max_db = heard ? 5 * std::ceil(level_at(levels, 0.9995) / 5) : scale.max_db;
  scale.show_min_db = scale.show_max_db - kShown_db;
  if (heard) {
    scale.show_min_db = std::clamp(5 * std::floor(level_at(levels, 0.3) / 5), scale.show_min_db,
                                   scale.show_max_db - 20);
  }
  return scale;
}

Result<Look> look_at(const PictureJob& job) {
  const std::vector<ShownPing>& shown = job.survey.shown;
  std::vector<PingLook> looks(shown.size());
  const Status done =
      for_each_picture(job.workers, job.stop, shown.size(), [&](std::size_t i) -> Status {
        const auto pixels = pixels_of(job, shown[i]);
        if (!pixels) return pixels.error();
        looks[i] = look_at_ping(*pixels, job.survey.sequences[shown[i].sequence]);
        return {};
      });
  if (!done) return done.error();
  LevelCounts levels;
  double least_rad = 1e9, most_rad = -1e9;
  std::vector<PingSpeckle> speckle;
  for (PingLook& look : looks) {
    levels.add(look.levels);
    least_rad = std::min(least_rad, look.least_rad);
    most_rad = std::max(most_rad, look.most_rad);
    speckle.push_back(std::move(look.speckle));
  }
  Look all;
  all.scale = scale_of(levels);
  // The user may have chosen limits for the 8-bit images.
  const auto& sequences = job.survey.sequences;
  if (levels.highest_db > kNoEnergyDb) {
    const auto& grey = sequences.front().facts.grey_db;
    if (grey && grey->second > grey->first) {
      all.scale.show_min_db = grey->first;
      all.scale.show_max_db = grey->second;
    }
  }
  if (most_rad >= least_rad) {
    all.scale.min_rad = least_rad;
    all.scale.max_rad = std::max(most_rad, least_rad + 1e-6);
  }
  all.speckle = speckle_from(job.survey, speckle);
  return all;
}

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
  // Draws that are the same in all pings of a sequence count once.
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
