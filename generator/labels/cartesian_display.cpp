#include "labels/cartesian_display.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/units.h"
#include "labels/cartesian.h"

namespace ensonify {
namespace {

constexpr double kOne = 1 << 15;  // of a fraction
constexpr float kUnit = 1.0f / (1 << 15);
// Prevents rounding from turning a footprint of one cell into two cells.
constexpr double kCellSlack = 1e-6;
constexpr float kLeast = std::numeric_limits<float>::min(), kMost = 1e37f;

float bounded(double value) {
  return static_cast<float>(std::clamp(value, double{kLeast}, double{kMost}));
}

float power_of(float level_db) {
  return level_db > kNoEnergyDb ? bounded(std::pow(10.0, double{level_db} / 10)) : 0;
}

// Levels of finished data sets are half floats. Few half floats lie between 1 and 256 dB, so their
// intensities are in a table.
class Intensities {
 public:
  Intensities() {
    for (std::uint32_t key = 0; key < kCount; ++key) {
      powers_[key] = power_of(std::bit_cast<float>((key << kUnused) + kFirst));
    }
  }

  float at(float level_db) const {
    const std::uint32_t number = std::bit_cast<std::uint32_t>(level_db) - kFirst;
    const bool is_listed = number < (kCount << kUnused) && (number & ((1u << kUnused) - 1)) == 0;
    return is_listed ? powers_[number >> kUnused] : power_of(level_db);
  }

 private:
  static constexpr int kUnused = 13;                                       // bits of a half
  static constexpr std::uint32_t kFirst = 0x3f800000u, kCount = 8u << 10;  // of 1 dB
  std::array<float, kCount> powers_{};
};

std::vector<float> intensities(std::span<const float> level_db) {
  static const Intensities table;
  std::vector<float> intensity(level_db.size());
  for (std::size_t i = 0; i < level_db.size(); ++i) intensity[i] = table.at(level_db[i]);
  return intensity;
}

// A position on an axis, between the point `first` and the next one.
struct Place {
  std::int32_t first = 0;
  std::uint16_t fraction = 0;
};

Place place_of(double position, int count) {
  const double inside = std::clamp(position, 0.0, count - 1.0);
  const auto first = std::min(static_cast<std::int32_t>(inside), std::max(count - 2, 0));
  // Rounded as std::lround does, which is a call of a library.
  const double units = (inside - first) * kOne;
  const auto whole = static_cast<std::int32_t>(units);
  return {first, static_cast<std::uint16_t>(whole + (units - whole >= 0.5))};
}

bool has_parts(double width) { return width - kCellSlack > 1; }
int parts(double width) { return std::max(1, static_cast<int>(std::ceil(width - kCellSlack))); }

// The mean of the four polar pixels around a place. Weights add to one exactly, and a weight of one
// gives the pixel itself.
inline float mixed(float a, float b, float c, float d, float along_beams, float along_samples) {
  const float near = (1 - along_beams) * a + along_beams * b;
  const float far = (1 - along_beams) * c + along_beams * d;
  return (1 - along_samples) * near + along_samples * far;
}

// From a polar pixel to the next beam and to the next sample.
struct Steps {
  std::int32_t beam = 0, sample = 0;
};

Steps cell_steps(const Footprints& f) { return {f.beams > 1 ? 1 : 0, f.samples > 1 ? f.beams : 0}; }

ENSONIFY_VECTOR_CLONES void interpolate(const float* __restrict intensity, Steps steps,
                                        const std::int32_t* __restrict from,
                                        const std::uint16_t* __restrict beam_fraction,
                                        const std::uint16_t* __restrict sample_fraction,
                                        std::size_t count, float* __restrict shown) {
  const std::int32_t right = steps.beam, up = steps.sample;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t at = from[i];
    shown[i] = mixed(intensity[at], intensity[at + right], intensity[at + up],
                     intensity[at + up + right], static_cast<float>(beam_fraction[i]) * kUnit,
                     static_cast<float>(sample_fraction[i]) * kUnit);
  }
}

double sample_at(const Footprints& f, std::size_t i) {
  return f.from[i] / f.beams + f.sample_fraction[i] / kOne;
}

// The width of a footprint in beams, at most that of the fan.
double width_at(const Footprints& f, double sample) {
  return std::min<double>(f.beams_samples_per_px / std::max(f.first_sample + sample, 0.5), f.beams);
}

// The mean over the parts of a footprint.
float mean_over(const Footprints& f, std::span<const float> intensity, std::size_t i) {
  const double sample = sample_at(f, i);
  const double beam = f.from[i] % f.beams + f.beam_fraction[i] / kOne;
  const double length = f.samples_per_px, width = width_at(f, sample);
  const int m = parts(length), n = parts(width);
  const Steps steps = cell_steps(f);
  float sum = 0;
  for (int k = 0; k < m; ++k) {
    const Place row = place_of(sample + length * ((k + 0.5) / m - 0.5), f.samples);
    const float* line = intensity.data() + std::size_t(row.first) * f.beams;
    for (int j = 0; j < n; ++j) {
      const Place column = place_of(beam + width * ((j + 0.5) / n - 0.5), f.beams);
      const float* at = line + column.first;
      sum += mixed(at[0], at[steps.beam], at[steps.sample], at[steps.sample + steps.beam],
                   static_cast<float>(column.fraction) * kUnit,
                   static_cast<float>(row.fraction) * kUnit);
    }
  }
  return sum / static_cast<float>(m * n);
}

// The gray level of an intensity: where each level begins, and where a search for it begins.
class GrayScale {
 public:
  // `offset_db`: the gain that is not in the intensities.
  GrayScale(const DisplayTable& table, double offset_db) {
    for (std::size_t k = 0; k < begins_.size(); ++k) {
      begins_[k] = bounded(std::pow(10.0, (table.steps_db[k] - offset_db) / 10));
    }
    first_ = key_of(begins_.front());
    starts_.resize(key_of(begins_.back()) - first_ + 1);
    std::size_t level = 0;
    for (std::uint32_t key = 0; key < starts_.size(); ++key) {
      const float edge = std::bit_cast<float>((key + first_) << kShift);
      while (level < begins_.size() - 1 && begins_[level] <= edge) ++level;
      starts_[key] = static_cast<std::uint8_t>(level);
    }
  }

  std::uint8_t at(float intensity) const {
    if (!(intensity >= begins_.front())) return 0;
    if (intensity >= begins_.back()) return 255;
    std::size_t level = starts_[key_of(intensity) - first_];
    while (intensity >= begins_[level]) ++level;
    return static_cast<std::uint8_t>(level);
  }

 private:
  static constexpr int kShift = 17;  // 64 entries per octave
  static std::uint32_t key_of(float value) { return std::bit_cast<std::uint32_t>(value) >> kShift; }

  std::array<float, 255> begins_{};
  std::vector<std::uint8_t> starts_;
  std::uint32_t first_ = 0;
};

}  // namespace

bool is_grid_of_fan(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                    const Record& record) {
  constexpr double kSpacingSlack = 1.01;
  const double samples_per_px = grid.m_per_px * (2.0 * sonar.bandwidth_hz / water.sound_speed_m_s);
  const double half_fan = std::min(furthest_azimuth_rad(sonar), kPi / 2);
  // The longest edge of a grid in samples: forward and back, or to both sides.
  const double reach = record.samples + 1.0 + sonar.first_range_m / range_step_m(sonar, water);
  const double longest = 2 * kSpacingSlack * reach;
  return sonar.beam_spacing_rad > 0 && samples_per_px > 0 &&
         grid.height_px * samples_per_px <= longest &&
         (grid.width_px - 2) * samples_per_px <= longest * std::sin(half_fan);
}

Footprints footprints(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                      const Record& record, std::span<const std::int32_t> map) {
  const double samples_per_m = 2.0 * sonar.bandwidth_hz / water.sound_speed_m_s;
  Footprints f;
  f.rows = grid.height_px;
  f.columns = grid.width_px;
  f.beams = sonar.beam_count;
  f.samples = record.samples;
  f.samples_per_px = grid.m_per_px * samples_per_m;
  f.beams_samples_per_px = f.samples_per_px / sonar.beam_spacing_rad;
  f.first_sample = sonar.first_range_m * samples_per_m;
  ENSONIFY_ASSERT(map.size() == std::size_t(f.rows) * f.columns);
  const auto inside = static_cast<std::size_t>(
      std::count_if(map.begin(), map.end(), [](std::int32_t polar) { return polar >= 0; }));
  f.to.reserve(inside);
  f.from.reserve(inside);
  f.beam_fraction.reserve(inside);
  f.sample_fraction.reserve(inside);
  const bool is_long = has_parts(f.samples_per_px);
  for (int row = 0; row < f.rows; ++row) {
    const double x = grid.x_top_m - (row + 0.5) * grid.m_per_px;
    for (int column = 0; column < f.columns; ++column) {
      const int to = row * f.columns + column;
      if (map[to] < 0) continue;
      const double y = grid.y_left_m - (column + 0.5) * grid.m_per_px;
      const double at_sample = std::sqrt(x * x + y * y) * samples_per_m - f.first_sample;
      const double at_beam = beam_place(sonar, std::atan2(y, x));
      const Place beam = place_of(at_beam, f.beams), sample = place_of(at_sample, f.samples);
      f.to.push_back(to);
      f.from.push_back(sample.first * f.beams + beam.first);
      f.beam_fraction.push_back(beam.fraction);
      f.sample_fraction.push_back(sample.fraction);
      if (is_long || has_parts(width_at(f, sample.first + sample.fraction / kOne))) {
        f.large.push_back(static_cast<std::uint32_t>(f.to.size() - 1));
      }
    }
  }
  return f;
}

std::vector<float> cartesian_gains(const DisplayTable& table, const Footprints& f) {
  std::vector<float> gains;
  if (table.display.spreading == 0 && table.alpha_db_m == 0) return gains;
  gains.reserve(f.to.size());
  for (std::size_t i = 0; i < f.to.size(); ++i) {
    const double range_m = std::max(f.first_sample + sample_at(f, i), 1.0) * table.step_m;
    const double tvg_db =
        table.display.spreading * std::log10(range_m) + 2 * table.alpha_db_m * range_m;
    gains.push_back(bounded(std::pow(10.0, (tvg_db - table.tvg_db.back()) / 10)));
  }
  return gains;
}

GreyImage displayed_cartesian(const DisplayTable& table, const Footprints& f,
                              std::span<const float> gains, double further_gain_db,
                              std::span<const float> level_db) {
  ENSONIFY_ASSERT(level_db.size() == std::size_t(f.beams) * f.samples);
  ENSONIFY_ASSERT(gains.empty() || gains.size() == f.to.size());
  GreyImage image{f.rows, f.columns, std::vector<std::uint8_t>(std::size_t(f.rows) * f.columns)};
  const std::vector<float> intensity = intensities(level_db);
  const GrayScale gray(table, further_gain_db + table.tvg_db.back());
  const Steps steps = cell_steps(f);
  constexpr std::size_t kBlock = 2048;
  std::array<float, kBlock> shown;
  auto large = f.large.begin();
  for (std::size_t start = 0; start < f.to.size(); start += kBlock) {
    const std::size_t count = std::min(kBlock, f.to.size() - start);
    interpolate(intensity.data(), steps, f.from.data() + start, f.beam_fraction.data() + start,
                f.sample_fraction.data() + start, count, shown.data());
    for (; large != f.large.end() && *large < start + count; ++large) {
      shown[*large - start] = mean_over(f, intensity, *large);
    }
    for (std::size_t i = 0; !gains.empty() && i < count; ++i) shown[i] *= gains[start + i];
    for (std::size_t i = 0; i < count; ++i) image.pixels[f.to[start + i]] = gray.at(shown[i]);
  }
  return image;
}

}  // namespace ensonify
