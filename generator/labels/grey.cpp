#include "labels/grey.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {

GreyImage grey_image(const LabelledImage& image, const std::array<double, 2>& db_limits) {
  GreyImage grey{image.rows, image.columns, {}};
  grey.pixels.resize(image.level_db.size());
  const double black = db_limits[0];
  const double scale = 255.0 / (db_limits[1] - black);
  const float* level = image.level_db.data();
  std::uint8_t* pixel = grey.pixels.data();
  for (std::size_t i = 0, count = grey.pixels.size(); i < count; ++i) {
    const double value = std::min(std::max(0.0, (level[i] - black) * scale), 255.0);
    pixel[i] = static_cast<std::uint8_t>(static_cast<int>(value + 0.5));
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
