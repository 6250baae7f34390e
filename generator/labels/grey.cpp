#include "labels/grey.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {

std::vector<double> shown_gain_db(const GreySettings& settings, double absorption_db_m,
                                  double step_m, int samples) {
  std::vector<double> gain_db;
  for (int n = 0; n < samples; ++n) {
    const double range_m = std::max(n, 1) * step_m;
    const double absorbed_db = settings.absorption ? 2 * absorption_db_m * range_m : 0;
    gain_db.push_back(settings.gain_db + settings.spreading * std::log10(range_m) + absorbed_db);
  }
  return gain_db;
}

std::vector<float> with_gain(std::span<const float> level_db, std::span<const double> gain_db) {
  std::vector<float> shown(level_db.begin(), level_db.end());
  const std::size_t columns = level_db.size() / gain_db.size();
  for (std::size_t n = 0; n < gain_db.size(); ++n) {
    for (float& level : std::span(shown).subspan(n * columns, columns)) {
      if (level > kNoEnergyDb) level = static_cast<float>(level + gain_db[n]);
    }
  }
  return shown;
}

GreyImage grey_image(int rows, int columns, std::span<const float> level_db, GreyScale scale,
                     const std::array<double, 2>& db_limits) {
  GreyImage grey{rows, columns, {}};
  grey.pixels.resize(level_db.size());
  const double black = db_limits[0], white = db_limits[1];
  const double slope = 255.0 / (white - black);
  const float* level = level_db.data();
  std::uint8_t* pixel = grey.pixels.data();
  const auto fill = [&](auto value_of) {
    for (std::size_t i = 0, count = grey.pixels.size(); i < count; ++i) {
      const double heard = level[i] > kNoEnergyDb ? value_of(level[i]) : 0.0;
      const double value = std::min(std::max(0.0, heard), 255.0);
      pixel[i] = static_cast<std::uint8_t>(static_cast<int>(value + 0.5));
    }
  };
  if (scale == GreyScale::db) {
    fill([=](float db) { return (db - black) * slope; });
  } else {
    fill([=](float db) { return 255 * std::pow(10.0, (db - white) / 20); });
  }
  return grey;
}

std::array<double, 2> db_limits_from_clean(std::span<const float> clean_db,
                                           std::span<const float> elevation_rad) {
  std::vector<float> levels;
  for (std::size_t i = 0; i < clean_db.size(); ++i) {
    if (!std::isnan(elevation_rad[i]) && clean_db[i] > kNoEnergyDb) {
      levels.push_back(clean_db[i]);
    }
  }
  if (levels.empty()) return {60, 120};
  const auto percentile = [&](double p) {
    const auto nth = levels.begin() + static_cast<std::ptrdiff_t>(p * (levels.size() - 1));
    std::nth_element(levels.begin(), nth, levels.end());
    return *nth;
  };
  const double white = std::ceil(percentile(0.99) + 6.0);
  const double black = std::floor(percentile(0.05) - 10.0);
  return {std::clamp(black, white - 80.0, white - 40.0), white};
}

}  // namespace ensonify
