#include "labels/grey.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {

GreyImage grey_image(const LabelledImage& image, const std::array<double, 2>& db_limits) {
  GreyImage grey{image.rows, image.columns, {}};
  grey.pixels.reserve(image.level_db.size());
  const double scale = 255.0 / (db_limits[1] - db_limits[0]);
  for (const float level : image.level_db) {
    const double value = std::clamp((level - db_limits[0]) * scale, 0.0, 255.0);
    grey.pixels.push_back(static_cast<std::uint8_t>(std::lround(value)));
  }
  return grey;
}

std::array<double, 2> db_limits_from_clean(const LabelledImage& polar) {
  std::vector<float> levels;
  for (std::size_t i = 0; i < polar.clean_db.size(); ++i) {
    if (!std::isnan(polar.elevation_rad[i]) && polar.clean_db[i] > kNoEnergyDb) {
      levels.push_back(polar.clean_db[i]);
    }
  }
  if (levels.empty()) return {60, 120};
  std::sort(levels.begin(), levels.end());
  const auto percentile = [&](double p) { return levels[std::size_t(p * (levels.size() - 1))]; };
  const double white = std::ceil(percentile(0.99) + 6.0);
  const double black = std::floor(percentile(0.05) - 10.0);
  return {std::clamp(black, white - 80.0, white - 40.0), white};
}

}  // namespace ensonify
