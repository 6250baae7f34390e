#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "core/levels.h"
#include "report/pictures.h"

namespace ensonify {
namespace {

constexpr int kLeastDb = -99, kLevels = 400;  // of the histogram, steps of 1 dB
constexpr double kSpan_db = 100;              // of codes, below the highest level
constexpr double kShown_db = 60;              // of the first view, at most

// What one ping adds.
struct PingLook {
  std::array<std::uint32_t, kLevels> levels{};
  float highest_db = kNoEnergyDb;
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
  for (const float db : pixels.level_db) {
    if (!(db > kNoEnergyDb)) continue;
    look.highest_db = std::max(look.highest_db, db);
    const int step = static_cast<int>(std::floor(db)) - kLeastDb;
    ++look.levels[static_cast<std::size_t>(std::clamp(step, 0, kLevels - 1))];
  }
  for (const float db : pixels.clean_db) look.highest_db = std::max(look.highest_db, db);
  for (const float rad : pixels.elevation_rad) {
    if (std::isnan(rad)) continue;
    look.least_rad = std::min<double>(look.least_rad, rad);
    look.most_rad = std::max<double>(look.most_rad, rad);
  }
  look.speckle = speckle_of(pixels, sequence);
  return look;
}

// The level below which that share of all pixels lies.
double level_at(const std::array<std::uint64_t, kLevels>& levels, double share) {
  std::uint64_t all = 0, below = 0;
  for (const std::uint64_t n : levels) all += n;
  int i = 0;
  while (i < kLevels - 1 && static_cast<double>(below) < share * static_cast<double>(all)) {
    below += levels[i++];
  }
  return kLeastDb + i;
}

// Of the grey pictures, which a person may have chosen; else what the levels suggest.
void choose_view(const Survey& survey, const std::array<std::uint64_t, kLevels>& levels,
                 PictureScale& scale) {
  const auto& grey = survey.sequences.front().facts.grey_db;
  if (grey && grey->second > grey->first) {
    scale.show_min_db = grey->first;
    scale.show_max_db = grey->second;
    return;
  }
  scale.show_max_db = 5 * std::ceil(level_at(levels, 0.9995) / 5);
  scale.show_min_db = std::clamp(5 * std::floor(level_at(levels, 0.3) / 5),
                                 scale.show_max_db - kShown_db, scale.show_max_db - 20);
}

}  // namespace

std::uint8_t grey_code(double value, double low, double high) {
  if (std::isnan(value)) return 0;
  const double code = 1 + 254 * (value - low) / (high - low);
  return static_cast<std::uint8_t>(std::lround(std::clamp(code, 1.0, 255.0)));
}

Result<StoredPixels> pixels_of(const PictureJob& job, const ShownPing& ping) {
  const StoredSequence& sequence = job.survey.sequences[ping.sequence].stored;
  const PictureChannels channels = stored_channels(sequence, StoredView::polar);
  auto pixels = read_picture(job.dataset, sequence, StoredView::polar, ping.ping, channels);
  if (!pixels || channels.level || !has_series(sequence)) return pixels;
  const auto series = read_series(job.dataset, sequence, ping.ping);
  if (!series) return series.error();
  pixels->level_db = levels_of(*series, sequence.beams, sequence.samples);
  return pixels;
}

Status for_each_picture(const PictureJob& job, std::size_t count,
                        const std::function<Status(std::size_t)>& use) {
  std::vector<Status> states(count);
  std::atomic<bool> stopped = false, failed = false;
  job.workers.for_each(count, [&](std::size_t i) {
    if (job.stop != nullptr && job.stop()) stopped = true;
    if (stopped || failed) return;
    states[i] = use(i);
    if (!states[i]) failed = true;
  });
  for (const Status& state : states) {
    if (!state) return state;
  }
  if (stopped) return Error{ErrorKind::interrupted, "interrupted; the page is not written"};
  return {};
}

Result<Look> look_at(const PictureJob& job) {
  const std::vector<ShownPing>& shown = job.survey.shown;
  std::vector<PingLook> looks(shown.size());
  const Status done = for_each_picture(job, shown.size(), [&](std::size_t i) -> Status {
    const auto pixels = pixels_of(job, shown[i]);
    if (!pixels) return pixels.error();
    looks[i] = look_at_ping(*pixels, job.survey.sequences[shown[i].sequence]);
    return {};
  });
  if (!done) return done.error();
  std::array<std::uint64_t, kLevels> levels{};
  double highest_db = kNoEnergyDb, least_rad = 1e9, most_rad = -1e9;
  std::vector<PingSpeckle> speckle;
  for (PingLook& look : looks) {
    for (int i = 0; i < kLevels; ++i) levels[i] += look.levels[i];
    highest_db = std::max<double>(highest_db, look.highest_db);
    least_rad = std::min(least_rad, look.least_rad);
    most_rad = std::max(most_rad, look.most_rad);
    speckle.push_back(std::move(look.speckle));
  }
  Look all;
  const bool heard = highest_db > kNoEnergyDb;
  all.scale.max_db = heard ? std::ceil(highest_db) : 140.0;
  all.scale.min_db = all.scale.max_db - kSpan_db;
  all.scale.show_min_db = all.scale.max_db - kShown_db;
  all.scale.show_max_db = all.scale.max_db;
  if (heard) choose_view(job.survey, levels, all.scale);
  if (most_rad >= least_rad) {
    all.scale.min_rad = least_rad;
    all.scale.max_rad = std::max(most_rad, least_rad + 1e-6);
  }
  all.speckle = speckle_from(job.survey, speckle);
  return all;
}

}  // namespace ensonify
