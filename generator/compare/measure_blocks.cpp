#include "compare/measure_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/measure_parts.h"
#include "core/error.h"

namespace ensonify {
namespace {

constexpr double kGroundOverFloor = 4;      // 6 dB
constexpr double kGroundUnderMedian = 0.1;  // 10 dB
constexpr int kFloorHalfRows = 4;

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The mean, since logs round azimuths: of steps that alternate, the median is that of one kind.
double mean_step(const std::vector<double>& at) {
  return at.size() > 1 ? (at.back() - at.front()) / static_cast<double>(at.size() - 1) : 1;
}

double median_interval(const PolarPings& pings) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < pings.block.size(); ++i) {
    if (pings.block[i] == pings.block[i - 1]) {
      intervals.push_back(pings.time_s[i] - pings.time_s[i - 1]);
    }
  }
  return median_of(std::move(intervals));
}

int bin_of(double value, double from, double to, int bins) {
  if (!(value >= from && value <= to) || !(to > from)) return -1;
  return std::min(bins - 1, static_cast<int>((value - from) / (to - from) * bins));
}

void set_windows(Frame& frame, double range_step, double azimuth_step) {
  const MeasureSettings& s = frame.settings;
  const auto steps = [](double size, double step) {
    return std::clamp(static_cast<int>(std::lround(size / step)), 1, 1000);
  };
  frame.half_rows = steps(s.range_window, range_step);
  frame.half_columns = steps(s.azimuth_window, azimuth_step);
  frame.guard_rows = std::max(1, frame.half_rows / 3);
  frame.guard_columns = std::max(1, (frame.half_columns + 1) / 3);
  frame.range_lags = std::min(400, static_cast<int>(std::ceil(kLags * s.range_lag / range_step)));
  frame.azimuth_lags =
      std::min(400, static_cast<int>(std::ceil(kLags * s.azimuth_lag / azimuth_step)));
}

// Mean intensity of each pixel over all pings, in bands of rows.
std::vector<double> mean_intensity(const PolarPings& pings, const Workers& workers) {
  const auto rows = static_cast<std::size_t>(pings.samples());
  const auto columns = static_cast<std::size_t>(pings.beams());
  std::vector<double> mean(rows * columns, 0);
  workers.for_each(rows, [&](std::size_t r) {
    for (const auto& amplitude : pings.amplitude) {
      for (std::size_t i = r * columns; i < (r + 1) * columns; ++i) {
        mean[i] += static_cast<double>(amplitude[i]) * static_cast<double>(amplitude[i]);
      }
    }
  });
  const auto count = static_cast<double>(std::max<std::size_t>(1, pings.amplitude.size()));
  for (double& value : mean) value /= count;
  return mean;
}

// The intensity from which a pixel is ground.
double ground_threshold(const Frame& frame, const std::vector<double>& mean,
                        const WindowSums& sums) {
  double floor = std::numeric_limits<double>::infinity();
  for (int r = 0; r < frame.rows; ++r) {
    const auto band = sums.rectangle(r - kFloorHalfRows, r + kFloorHalfRows, 0, frame.columns - 1);
    if (band.count > 0 && band.sum > 0) floor = std::min(floor, band.mean());
  }
  std::vector<double> used;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    if (frame.measured[i] != 0 && mean[i] > 0) used.push_back(mean[i]);
  }
  if (!std::isfinite(floor)) return 0;
  return std::min(kGroundOverFloor * floor, kGroundUnderMedian * median_of(std::move(used)));
}

// Bins and measured pixels; no ground.
Frame frame_of(const PolarPings& pings, const MeasureSettings& settings) {
  Frame frame;
  frame.settings = settings;
  frame.rows = pings.samples();
  frame.columns = pings.beams();
  frame.range_m = pings.range_m;
  set_windows(frame, mean_step(pings.range_m), mean_step(pings.azimuth_rad));
  const double far_from = settings.range_to - (settings.range_to - settings.range_from) / 10;
  for (const double range : pings.range_m) {
    frame.range_bin.push_back(
        bin_of(range, settings.range_from, settings.range_to, kLevelRangeBins));
    frame.shape_bin.push_back(bin_of(range, settings.range_from, settings.range_to, kShapeBins));
    frame.is_far.push_back(range >= far_from);
  }
  for (const double azimuth : pings.azimuth_rad) {
    frame.azimuth_bin.push_back(
        bin_of(azimuth, settings.azimuth_from, settings.azimuth_to, kLevelAzimuthBins));
  }
  frame.measured.assign(frame.at(frame.rows, 0), 0);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      frame.measured[i] = frame.range_bin[static_cast<std::size_t>(r)] >= 0 &&
                          frame.azimuth_bin[static_cast<std::size_t>(c)] >= 0 &&
                          (pings.use.empty() || pings.use[i] != 0);
    }
  }
  return frame;
}

GroundRegion ground_of(const PolarPings& pings, const MeasureSettings& settings,
                       const Workers& workers) {
  const Frame frame = frame_of(pings, settings);
  const std::vector<double> mean = mean_intensity(pings, workers);
  const WindowSums sums(std::span<const double>(mean), frame.measured, frame.rows, frame.columns);
  const double threshold = ground_threshold(frame, mean, sums);
  GroundRegion region{pings.range_m, pings.azimuth_rad, {}};
  region.is_ground.assign(mean.size(), 0);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      region.is_ground[i] =
          frame.measured[i] != 0 &&
          sums.around(r, c, frame.half_rows / 2, frame.half_columns / 2).mean() > threshold;
    }
  }
  return region;
}

// The index of the nearest value of a rising axis.
std::size_t nearest(const std::vector<double>& axis, double value) {
  const auto after = std::lower_bound(axis.begin(), axis.end(), value);
  if (after == axis.begin()) return 0;
  const auto i = static_cast<std::size_t>(after - axis.begin());
  if (after == axis.end()) return i - 1;
  return value - axis[i - 1] < axis[i] - value ? i - 1 : i;
}

bool is_in(const GroundRegion& region, double range_m, double azimuth_rad) {
  return region.is_ground[nearest(region.range_m, range_m) * region.azimuth_rad.size() +
                          nearest(region.azimuth_rad, azimuth_rad)] != 0;
}

// The pixels of the first that lie in both, less half a window along the rim.
GroundRegion common_ground(GroundRegion a, const GroundRegion& b, const MeasureSettings& settings) {
  const std::size_t columns = a.azimuth_rad.size();
  for (std::size_t i = 0; i < a.is_ground.size(); ++i) {
    a.is_ground[i] =
        a.is_ground[i] != 0 && is_in(b, a.range_m[i / columns], a.azimuth_rad[i % columns]);
  }
  Frame frame;
  frame.settings = settings;
  set_windows(frame, mean_step(a.range_m), mean_step(a.azimuth_rad));
  const std::vector<std::uint8_t> all(a.is_ground.size(), 1);
  const int rows = static_cast<int>(a.range_m.size()), beams = static_cast<int>(columns);
  const WindowSums sums(std::span<const std::uint8_t>(a.is_ground), all, rows, beams);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < beams; ++c) {
      const auto window = sums.around(r, c, frame.half_rows / 2, frame.half_columns / 2);
      if (window.sum < window.count) {
        a.is_ground[static_cast<std::size_t>(r) * columns + static_cast<std::size_t>(c)] = 0;
      }
    }
  }
  return a;
}

void set_ground(Frame& frame, const PolarPings& pings) {
  constexpr double kWholeRow = 0.9;
  frame.ground.assign(frame.measured.size(), 0);
  for (int r = 0; r < frame.rows; ++r) {
    double ground = 0;
    for (int c = 0; c < frame.columns; ++c) {
      const std::size_t i = frame.at(r, c);
      frame.ground[i] = frame.measured[i] != 0 &&
                        is_in(frame.settings.ground, pings.range_m[static_cast<std::size_t>(r)],
                              pings.azimuth_rad[static_cast<std::size_t>(c)]);
      ground += frame.ground[i];
    }
    frame.is_whole.push_back(ground >= kWholeRow * frame.columns);
  }
}

void set_top(Frame& frame, const PolarPings& pings, const Workers& workers) {
  std::vector<float> tops(pings.amplitude.size(), 0);
  workers.for_each(tops.size(), [&](std::size_t i) {
    for (const float a : pings.amplitude[i]) tops[i] = std::max(tops[i], a);
  });
  for (const float top : tops) frame.top = std::max(frame.top, top);
}

struct MeasuredImage {
  Sums sums;
  std::vector<PatchFeatures> patches;
  std::vector<float> x;
};

MeasuredImage measure_image(const Frame& frame, const GridImage& image, double height_m) {
  MeasuredImage measured;
  Picture picture = picture_of(frame, image);
  measured.sums.images = 1;
  add_levels(frame, picture, height_m, measured.sums);
  add_texture(frame, picture, measured.sums);
  add_patches(frame, picture, measured.patches);
  add_plain_patches(frame, picture, measured.sums);
  add_patterns(frame, picture, measured.sums);
  if (!frame.settings.crops) {
    add_maxima(frame, picture, measured.sums);
    add_darkness(frame, picture, measured.sums);
    add_comb(frame, picture, measured.sums);
    add_classes(frame, picture, measured.sums);
    measured.x = std::move(picture.x);
  }
  return measured;
}

// Adds up the images of each block in their order.
void gather(std::vector<MeasuredImage>& images, const std::vector<std::uint32_t>& block,
            BlockStatistics& statistics) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    add(statistics.blocks[block[i]], images[i].sums);
    auto& patches = statistics.patches[block[i]];
    patches.insert(patches.end(), images[i].patches.begin(), images[i].patches.end());
  }
  for (const Sums& sums : statistics.blocks) add(statistics.all, sums);
}

}  // namespace

MeasureSettings common_settings(const PolarPings& a, const PolarPings& b, const Workers& workers) {
  ENSONIFY_ASSERT(!a.range_m.empty() && !b.range_m.empty());
  ENSONIFY_ASSERT(!a.azimuth_rad.empty() && !b.azimuth_rad.empty());
  MeasureSettings settings;
  settings.range_lag = std::max(mean_step(a.range_m), mean_step(b.range_m));
  settings.azimuth_lag = std::max(mean_step(a.azimuth_rad), mean_step(b.azimuth_rad));
  settings.range_window *= settings.range_lag;
  settings.azimuth_window *= settings.azimuth_lag;
  settings.range_from = std::max(a.range_m.front(), b.range_m.front());
  settings.range_to = std::min(a.range_m.back(), b.range_m.back());
  settings.azimuth_from = std::max(a.azimuth_rad.front(), b.azimuth_rad.front());
  settings.azimuth_to = std::min(a.azimuth_rad.back(), b.azimuth_rad.back());
  settings.ground =
      common_ground(ground_of(a, settings, workers), ground_of(b, settings, workers), settings);
  return settings;
}

MeasureSettings crop_settings() {
  MeasureSettings settings;
  settings.crops = true;
  return settings;
}

BlockStatistics measure_pings(const PolarPings& pings, const MeasureSettings& settings,
                              const Workers& workers) {
  ENSONIFY_ASSERT(!settings.ground.is_ground.empty());
  Frame frame = frame_of(pings, settings);
  set_ground(frame, pings);
  set_top(frame, pings, workers);
  BlockStatistics statistics;
  statistics.settings = settings;
  statistics.range_step = mean_step(pings.range_m);
  statistics.azimuth_step = mean_step(pings.azimuth_rad);
  statistics.ping_interval_s = median_interval(pings);
  statistics.half_rows = frame.half_rows;
  statistics.half_columns = frame.half_columns;
  statistics.images = pings.amplitude.size();
  statistics.blocks.resize(pings.blocks());
  statistics.patches.resize(pings.blocks());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<MeasuredImage> images(pings.amplitude.size());
  workers.for_each(images.size(), [&](std::size_t i) {
    images[i] =
        measure_image(frame, pings.image(i), pings.height_m.empty() ? unknown : pings.height_m[i]);
  });
  workers.for_each(images.size(), [&](std::size_t i) {
    for (std::size_t lag = 0; lag <= kPingLags; ++lag) {
      if (i + lag < images.size() && pings.block[i + lag] == pings.block[i]) {
        add_ping_pairs(images[i].x, images[i + lag].x, static_cast<int>(lag), images[i].sums);
      }
    }
  });
  gather(images, pings.block, statistics);
  return statistics;
}

BlockStatistics measure_crops(const Crops& crops, const MeasureSettings& settings,
                              const Workers& workers) {
  BlockStatistics statistics;
  statistics.settings = settings;
  statistics.images = crops.crops.size();
  statistics.blocks.resize(crops.blocks());
  statistics.patches.resize(crops.blocks());
  Frame frame;
  frame.settings = settings;
  set_windows(frame, 1, 1);
  statistics.half_rows = frame.half_rows;
  statistics.half_columns = frame.half_columns;
  for (const Crops::Crop& crop : crops.crops) {
    for (const float amplitude : crop.amplitude) frame.top = std::max(frame.top, amplitude);
  }
  std::vector<MeasuredImage> images(crops.crops.size());
  workers.for_each(images.size(), [&](std::size_t i) {
    Frame own = frame;
    own.rows = crops.crops[i].rows;
    own.columns = crops.crops[i].columns;
    own.measured.assign(crops.crops[i].amplitude.size(), 1);
    own.ground = own.measured;
    images[i] = measure_image(own, crops.image(i), std::numeric_limits<double>::quiet_NaN());
  });
  gather(images, crops.block, statistics);
  return statistics;
}

}  // namespace ensonify
