#include "labels/display.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/compile_targets.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr int kStarts = 4096;
constexpr double kAutomaticRank = 0.995;
// Shares of white pixels that the default limits allow.
constexpr double kWhiteOfAll = 0.002, kWhiteOfEchoes = 0.1;
constexpr double kBlackRank = 0.05, kUnderBlackRank_db = 15;
constexpr double kLeastSpan_db = 45, kMostSpan_db = 75;
constexpr int kBinsPerDb = 4;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

std::array<double, 256> steps_of(const Display& display) {
  const auto [black, white] = display.limits_db;
  std::array<double, 256> steps{};
  for (int k = 1; k <= 255; ++k) {
    steps[static_cast<std::size_t>(k - 1)] =
        display.scale == GreyScale::db ? (k - 0.5) * (white - black) / 255 + black
                                       : 20 * std::log10((k - 0.5) / 255) / display.gamma + white;
  }
  steps.back() = std::numeric_limits<double>::infinity();
  return steps;
}

// One entry early, so that rounding never makes the search begin too late.
void add_starts(DisplayTable& table) {
  const auto& steps = table.steps_db;
  table.starts_per_db = kStarts / (steps[254] - steps[0]);
  for (int i = 0; i < kStarts + 2; ++i) {
    const double edge_db = steps[0] + (i - 1.0) / table.starts_per_db;
    const auto after = std::upper_bound(steps.begin(), steps.end() - 1, edge_db);
    table.starts.push_back(static_cast<std::int32_t>(after - steps.begin()));
  }
  for (std::size_t i = 0; i < table.starts.size(); ++i) {
    const std::int32_t end = i + 2 < table.starts.size() ? table.starts[i + 2] : 255;
    table.most_steps = std::max(table.most_steps, end - table.starts[i]);
  }
}

// A part of a row and scratch for its search.
struct Part {
  static constexpr std::size_t kSize = 512;
  std::array<double, kSize> shown_db;
  std::array<std::int32_t, kSize> gray;
};

// The levels that a row with one gain shows, and where in `starts` to look for them.
ENSONIFY_VECTOR_CLONES void find_places(double first_db, double starts_per_db, double tvg_db,
                                        double further_db, const float* __restrict level_db,
                                        std::size_t count, double* __restrict shown_db,
                                        std::int32_t* __restrict place) {
  for (std::size_t i = 0; i < count; ++i) shown_db[i] = level_db[i] + tvg_db + further_db;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = (shown_db[i] - first_db) * starts_per_db;
    const double above = at > 0 ? at : 0;
    const double inside = above < kStarts + 1 ? above : kStarts + 1;
    place[i] = static_cast<std::int32_t>(inside);
  }
}

// The gray levels of levels from a part of a row. Tables are read by plain loads, which are faster
// than gathering instructions.
void find_grays(const DisplayTable& table, double tvg_db, double further_db, const float* level_db,
                std::size_t count, Part& part) {
  find_places(table.steps_db[0], table.starts_per_db, tvg_db, further_db, level_db, count,
              part.shown_db.data(), part.gray.data());
  const std::int32_t* starts = table.starts.data();
  for (std::size_t i = 0; i < count; ++i) {
    std::int32_t gray = starts[part.gray[i]];
    for (int k = 0; k < table.most_steps; ++k) gray += part.shown_db[i] >= table.steps_db[gray];
    part.gray[i] = level_db[i] > kNoEnergyDb ? gray : 0;
  }
}

// Writes the pixels of a row and counts them.
ENSONIFY_VECTOR_CLONES void put_grays(const std::int32_t* __restrict gray,
                                      const float* __restrict elevation_rad, std::size_t count,
                                      std::uint8_t* __restrict pixels, DisplayCounts& counts) {
  std::uint32_t white = 0, echo = 0, black = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t is_echo = elevation_rad[i] == elevation_rad[i];
    pixels[i] = static_cast<std::uint8_t>(gray[i]);
    white += gray[i] == 255;
    echo += is_echo;
    black += is_echo & static_cast<std::uint32_t>(gray[i] == 0);
  }
  counts += {count, white, echo, black};
}

// The gain in addition to the time-varied gain.
double further_gain_db(const DisplayTable& table, std::size_t columns,
                       std::span<const float> level_db) {
  const Display& display = table.display;
  if (!display.automatic_gain) return display.gain_db;
  std::vector<double> levels;
  for (std::size_t i = 0; i < level_db.size(); ++i) {
    if (level_db[i] > kNoEnergyDb) levels.push_back(level_db[i] + table.tvg_db[i / columns]);
  }
  if (levels.empty()) return display.gain_db;
  const auto rank =
      static_cast<std::ptrdiff_t>(kAutomaticRank * static_cast<double>(levels.size() - 1));
  std::nth_element(levels.begin(), levels.begin() + rank, levels.end());
  return display.gain_db + (display.limits_db[1] - levels[static_cast<std::size_t>(rank)]);
}

}  // namespace

DisplayTable display_table(const Display& display, double absorption_db_m, double step_m,
                           int samples, double first_range_m) {
  DisplayTable table;
  table.display = display;
  table.alpha_db_m = display.absorption ? absorption_db_m : 0;
  table.step_m = step_m;
  for (int n = 0; n < samples; ++n) {
    const double range_m = std::max(first_range_m + n * step_m, step_m);
    table.tvg_db.push_back(display.spreading * std::log10(range_m) +
                           2 * table.alpha_db_m * range_m);
  }
  table.steps_db = steps_of(display);
  add_starts(table);
  return table;
}

DisplayedImage displayed(const DisplayTable& table, int rows, int columns,
                         std::span<const float> level_db, std::span<const float> elevation_rad) {
  DisplayedImage image{{rows, columns, std::vector<std::uint8_t>(level_db.size())}, {}, 0};
  if (level_db.empty()) return image;
  const std::size_t width = level_db.size() / table.tvg_db.size();
  const double further_db = further_gain_db(table, width, level_db);
  image.further_gain_db = further_db;
  Part part;
  std::array<float, Part::kSize> known;  // instead of elevations
  std::size_t at = 0;
  for (const double tvg_db : table.tvg_db) {
    for (const std::size_t end = at + width; at < end;) {
      const std::size_t count = std::min(Part::kSize, end - at);
      const float* level = level_db.data() + at;
      find_grays(table, tvg_db, further_db, level, count, part);
      if (elevation_rad.empty()) {
        std::transform(level, level + count, known.begin(),
                       [](float db) { return db > kNoEnergyDb ? 0 : kUnknown; });
      }
      put_grays(part.gray.data(), elevation_rad.empty() ? known.data() : elevation_rad.data() + at,
                count, image.grey.pixels.data() + at, image.counts);
      at += count;
    }
  }
  return image;
}

void EchoLevels::add(const EchoLevels& more) {
  db.insert(db.end(), more.db.begin(), more.db.end());
  pixels += more.pixels;
}

EchoLevels echo_levels(const DisplayTable& table, const LabelledImage& polar,
                       double noise_power_pa2) {
  const auto columns = static_cast<std::size_t>(polar.columns);
  if (polar.clean_db.empty()) {
    EchoLevels levels{{}, polar.level_db.size()};
    for (std::size_t i = 0; i < polar.level_db.size(); ++i) {
      const float level = polar.level_db[i];
      if (level > kNoEnergyDb) {
        levels.db.push_back(static_cast<float>(level + table.tvg_db[i / columns]));
      }
    }
    return levels;
  }
  const auto above = [&](double least_db) {
    EchoLevels levels{{}, polar.clean_db.size()};
    for (std::size_t i = 0; i < polar.clean_db.size(); ++i) {
      const float clean_db = polar.clean_db[i];
      if (std::isnan(polar.elevation_rad[i]) || !(clean_db > kNoEnergyDb)) continue;
      if (clean_db < least_db) continue;
      levels.db.push_back(static_cast<float>(clean_db + table.tvg_db[i / columns]));
    }
    return levels;
  };
  EchoLevels heard = above(level_db(noise_power_pa2));
  return heard.db.empty() ? above(kNoEnergyDb) : heard;
}

namespace {

// The lowest limit, in whole dB, that speckle over `levels_db` is expected to reach no more than
// `most` times.
double white_limit_db(std::span<const float> levels_db, double most) {
  std::map<double, double> counts;  // by level, rounded
  for (const float level_db : levels_db) {
    counts[std::round(level_db * kBinsPerDb) / kBinsPerDb] += 1;
  }
  const auto expected = [&](double white_db) {
    double sum = 0;
    for (const auto& [level_db, count] : counts) {
      sum += count * std::exp(-std::pow(10.0, (white_db - level_db) / 10));
    }
    return sum;
  };
  // Speckle reaches a level this far above the highest expected one once in 20,000 pixels.
  double white_db = std::ceil(counts.rbegin()->first) + 10;
  while (expected(white_db - 1) <= most) --white_db;
  return white_db;
}

}  // namespace

std::array<double, 2> default_limits_db(EchoLevels levels) {
  auto& db = levels.db;
  if (db.empty()) return Display{}.limits_db;
  const auto echoes = static_cast<double>(db.size()), all = static_cast<double>(levels.pixels);
  const double white = white_limit_db(db, std::min(kWhiteOfAll * all, kWhiteOfEchoes * echoes));
  const auto rank = db.begin() + static_cast<std::ptrdiff_t>(kBlackRank * (echoes - 1));
  std::nth_element(db.begin(), rank, db.end());
  const double black = std::floor(*rank - kUnderBlackRank_db);
  return {std::clamp(black, white - kMostSpan_db, white - kLeastSpan_db), white};
}

std::array<double, 2> db_limits_from_clean(std::span<const float> clean_db,
                                           std::span<const float> elevation_rad,
                                           double noise_power_pa2) {
  LabelledImage image;
  image.columns = 1;
  image.clean_db.assign(clean_db.begin(), clean_db.end());
  image.elevation_rad.assign(elevation_rad.begin(), elevation_rad.end());
  const int samples = static_cast<int>(clean_db.size());
  return default_limits_db(echo_levels(display_table({}, 0, 1, samples), image, noise_power_pa2));
}

std::array<double, 2> db_limits_from_levels(std::span<const float> level_db) {
  LabelledImage image;
  image.columns = 1;
  image.level_db.assign(level_db.begin(), level_db.end());
  const int samples = static_cast<int>(level_db.size());
  return default_limits_db(echo_levels(display_table({}, 0, 1, samples), image, 0));
}

}  // namespace ensonify
