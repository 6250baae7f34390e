// Local normalization, and moments and autocovariance of the normalized intensity.
#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"
#include "core/error.h"

namespace ensonify {
namespace {

constexpr double kSurroundings = 2.5;  // of the window's size
constexpr double kLeastOfWindow = 0.75;
constexpr double kHomogeneous = 3;  // dB
constexpr double kEcho = 20;        // dB over the mean level of the surroundings

void add_pairs(const Frame& frame, const std::vector<float>& x, bool along_rows, int lags,
               Sums::Row& products, Sums::Row& pairs) {
  products.assign(static_cast<std::size_t>(lags) + 1, 0);
  pairs.assign(products.size(), 0);
  const std::size_t stride = along_rows ? static_cast<std::size_t>(frame.columns) : 1;
  for (int lag = 0; lag <= lags; ++lag) {
    const int last_row = frame.rows - (along_rows ? lag : 0);
    const int last_column = frame.columns - (along_rows ? 0 : lag);
    const std::size_t step = stride * static_cast<std::size_t>(lag);
    double sum = 0, count = 0;
    for (int r = 0; r < last_row; ++r) {
      const float* at = x.data() + frame.at(r, 0);
      for (int c = 0; c < last_column; ++c) {
        const float a = at[c], b = at[static_cast<std::size_t>(c) + step];
        const bool both = a >= 0 && b >= 0;
        sum += both ? static_cast<double>((a - 1) * (b - 1)) : 0.0;
        count += both ? 1.0 : 0.0;
      }
    }
    products[static_cast<std::size_t>(lag)] = sum;
    pairs[static_cast<std::size_t>(lag)] = count;
  }
}

// Echoes of objects: pixels far over the level around them.
std::vector<std::uint8_t> echoes_of(const Frame& frame, const Picture& picture, int half_rows,
                                    int half_columns) {
  std::vector<std::uint8_t> echoes(picture.level.size(), 0);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      if (frame.measured[i] == 0) continue;
      const double around = picture.levels.around(r, c, half_rows, half_columns).mean();
      echoes[i] = static_cast<double>(picture.level[i]) > around + kEcho;
    }
  }
  return echoes;
}

std::vector<float> normalized(const Frame& frame, const Picture& picture) {
  std::vector<float> x(picture.intensity.size(), kNoValue);
  const double whole = (2.0 * frame.half_rows + 1) * (2.0 * frame.half_columns + 1);
  const int far_rows = static_cast<int>(kSurroundings * frame.half_rows);
  const int far_columns = static_cast<int>(kSurroundings * frame.half_columns);
  const std::vector<std::uint8_t> echoes = echoes_of(frame, picture, far_rows, far_columns);
  const WindowSums echo_sums(std::span<const std::uint8_t>(echoes), frame.measured, frame.rows,
                             frame.columns);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      if (frame.ground[i] == 0) continue;
      const auto window = picture.sums.around(r, c, frame.half_rows, frame.half_columns);
      if (window.count < kLeastOfWindow * whole || !(window.sum > 0)) continue;
      if (echo_sums.around(r, c, frame.half_rows, frame.half_columns).sum > 0) continue;
      const double near = picture.levels.around(r, c, frame.half_rows, frame.half_columns).mean();
      const double wide = picture.levels.around(r, c, far_rows, far_columns).mean();
      if (std::abs(near - wide) > kHomogeneous) continue;
      x[i] = static_cast<float>(static_cast<double>(picture.intensity[i]) / window.mean());
    }
  }
  return x;
}

}  // namespace

Picture picture_of(const Frame& frame, const GridImage& image) {
  const std::size_t count = image.amplitude.size();
  ENSONIFY_ASSERT(count == frame.at(frame.rows, 0) && frame.measured.size() == count);
  std::vector<float> intensity(count), level(count);
  float lowest = frame.top;
  for (const float a : image.amplitude) {
    if (a > 0) lowest = std::min(lowest, a);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float a = image.amplitude[i];
    intensity[i] = a * a;
    level[i] = lowest > 0 ? 20 * std::log10(std::max(a, lowest)) : 0;
  }
  const auto sums_of = [&](std::span<const float> values) {
    return WindowSums(values, frame.measured, frame.rows, frame.columns);
  };
  WindowSums sums = sums_of(intensity), levels = sums_of(level);
  Picture picture{image, std::move(intensity), std::move(level),
                  {},    std::move(sums),      std::move(levels)};
  picture.x = normalized(frame, picture);
  return picture;
}

void add_texture(const Frame& frame, const Picture& picture, Sums& sums) {
  for (Sums::Row* row : {&sums.range_x0, &sums.range_x1, &sums.range_x2}) row->resize(kShapeBins);
  for (int r = 0; r < frame.rows; ++r) {
    const int bin = frame.shape_bin.empty() ? -1 : frame.shape_bin[static_cast<std::size_t>(r)];
    for (int c = 0; c < frame.columns; ++c) {
      const auto x = static_cast<double>(picture.x[frame.at(r, c)]);
      if (x < 0) continue;
      sums.x0 += 1;
      sums.x1 += x;
      sums.x2 += x * x;
      if (bin >= 0) {
        const auto k = static_cast<std::size_t>(bin);
        sums.range_x0[k] += 1;
        sums.range_x1[k] += x;
        sums.range_x2[k] += x * x;
      }
      if (x > 0) {
        const double level = 10 * std::log10(x);
        sums.log0 += 1;
        sums.log1 += level;
        sums.log2 += level * level;
        sums.log3 += level * level * level;
      }
    }
  }
  add_pairs(frame, picture.x, true, frame.range_lags, sums.range_products, sums.range_pairs);
  add_pairs(frame, picture.x, false, frame.azimuth_lags, sums.azimuth_products, sums.azimuth_pairs);
}

void add_ping_pairs(const std::vector<float>& x, const std::vector<float>& later, int lag,
                    Sums& sums) {
  sums.ping_products.resize(kPingLags + 1, 0);
  sums.ping_pairs.resize(kPingLags + 1, 0);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool both = x[i] >= 0 && later[i] >= 0;
    sum += both ? static_cast<double>((x[i] - 1) * (later[i] - 1)) : 0.0;
    count += both ? 1.0 : 0.0;
  }
  sums.ping_products[static_cast<std::size_t>(lag)] += sum;
  sums.ping_pairs[static_cast<std::size_t>(lag)] += count;
}

}  // namespace ensonify
