#include "labels/footprints.h"

#include <algorithm>
#include <cmath>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr int kBits = kPlaceBits;
constexpr std::int64_t kWhole = 1 << kBits;
constexpr double kOne = 1 << kBits;
// Prevents rounding from turning a footprint of one cell into two cells.
constexpr double kCellSlack = 1e-6;

// A place on an axis of `count` points, in units of a fraction, before it is rounded down.
inline double unrounded_place(double position, int count) {
  return std::clamp(position, 0.0, count - 1.0) * kOne + 0.5;
}
std::int64_t place_of(double position, int count) {
  return static_cast<std::int64_t>(unrounded_place(position, count));
}

bool has_parts(double width) { return width - kCellSlack > 1; }
int parts(double width) { return std::max(1, static_cast<int>(std::ceil(width - kCellSlack))); }
double middle_of_part(int part, int parts) { return (part + 0.5) / parts - 0.5; }

// From the middle of a footprint to that of a part, rounded.
std::int64_t offset_of_part(double length, int part, int parts) {
  return static_cast<std::int64_t>(std::floor(length * middle_of_part(part, parts) * kOne + 0.5));
}

// Of the middle of a pixel, in the sonar's plane, x ahead.
double x_of_row(const CartesianGrid& grid, int row) {
  return grid.x_top_m - (row + 0.5) * grid.m_per_px;
}
double y_of_column(const CartesianGrid& grid, int column) {
  return grid.y_left_m - (column + 0.5) * grid.m_per_px;
}

inline double sample_position(const Footprints& f, double x, double y) {
  return std::sqrt(x * x + y * y) * f.samples_per_m - f.first_sample;
}

// Neighboring pixels of a row, and their places.
constexpr int kSpan_px = 16;
struct PixelSpan {
  std::int32_t to = 0;  // the first pixel
  int count = 0;
  double x = 0;  // of all of them, and y of each
  double y[kSpan_px], azimuth_rad[kSpan_px], sample[kSpan_px];
};

// Azimuths differ from atan2 by less than this. Where that matters, atan2 decides.
constexpr double kAzimuthSlack_rad = 1e-12;
// The series of place_span needs pixels that are further from the sonar than this.
constexpr double kFar_px = 128;

// From the middle pixel with azimuth a and y = m, the tangent of the angle to a pixel of the same
// row is t = x (y - m) / (x^2 + y m), and atan t = t - t^3 / 3 + t^5 / 5 - ...
// Far pixels have |t| < 1/15.
ENSONIFY_VECTOR_CLONES void azimuths_from(double middle_y, double middle_rad, PixelSpan& span) {
  for (int i = 0; i < kSpan_px; ++i) {
    const double y = span.y[i];
    const double t = span.x * (y - middle_y) / (span.x * span.x + y * middle_y), t2 = t * t;
    const double series = 1 - t2 * (1.0 / 3 - t2 * (1.0 / 5 - t2 * (1.0 / 7 - t2 / 9)));
    span.azimuth_rad[i] = middle_rad + t * series;
  }
}

ENSONIFY_VECTOR_CLONES void samples_of(const Footprints& f, PixelSpan& span) {
  for (int i = 0; i < kSpan_px; ++i) {
    span.sample[i] = unrounded_place(sample_position(f, span.x, span.y[i]), f.samples);
  }
}

// Places a span whose first pixel and count are given. What lies beyond its last pixel has no
// meaning.
void place_span(const Footprints& f, PixelSpan& span) {
  const int row = span.to / f.grid.width_px, column = span.to % f.grid.width_px;
  span.x = x_of_row(f.grid, row);
  for (int i = 0; i < kSpan_px; ++i) span.y[i] = y_of_column(f.grid, column + i);
  samples_of(f, span);
  const double middle_y = span.y[span.count / 2], far_m = kFar_px * f.grid.m_per_px;
  if (span.x > 0 && span.x * span.x + middle_y * middle_y > far_m * far_m) {
    azimuths_from(middle_y, std::atan2(middle_y, span.x), span);
  } else {
    for (int i = 0; i < span.count; ++i) span.azimuth_rad[i] = std::atan2(span.y[i], span.x);
  }
}

// The places of azimuths among the beams.
class BeamPlaces {
 public:
  explicit BeamPlaces(const Sonar& sonar) : sonar_(sonar) {
    double least_rad = sonar.beam_spacing_rad;
    for (std::size_t j = 1; j < sonar.azimuth_rad.size(); ++j) {
      least_rad = std::min(least_rad, sonar.azimuth_rad[j] - sonar.azimuth_rad[j - 1]);
    }
    slack_ = least_rad > 0 ? kOne * kAzimuthSlack_rad / least_rad : 1;
  }

  std::int64_t at(const PixelSpan& span, int i) const {
    const double place = unrounded(span.azimuth_rad[i]);
    const auto rounded = static_cast<std::int64_t>(place);
    const double rest = place - static_cast<double>(rounded);
    if (rest > slack_ && rest < 1 - slack_) return rounded;
    return static_cast<std::int64_t>(unrounded(std::atan2(span.y[i], span.x)));
  }

 private:
  double unrounded(double azimuth_rad) const {
    return unrounded_place(beam_place(sonar_, azimuth_rad), sonar_.beam_count);
  }

  const Sonar& sonar_;
  double slack_;  // of places; 1: atan2 always decides
};

// The width of a footprint in beams, at most that of the fan.
double width_at(const Footprints& f, double sample) {
  return std::min<double>(f.beams_samples_per_px / std::max(f.first_sample + sample, 0.5), f.beams);
}

// Adds the weights of the two points around a place; `first`: that of sums[0].
template <class T>
void add_weights(std::int64_t place, std::int64_t first, T* sums) {
  const std::int64_t point = (place >> kBits) - first, fraction = place & (kWhole - 1);
  sums[point] = static_cast<T>(sums[point] + kWhole - fraction);
  sums[point + 1] = static_cast<T>(sums[point + 1] + fraction);
}

// Adds pixels to Footprints.
class FootprintMaker {
 public:
  FootprintMaker(Footprints& f, std::size_t pixels)
      : f_(f), last_((f.samples - std::int64_t{1}) << kBits) {
    // Widths fall with range.
    for (std::int64_t end = last_ + 1; first_narrow_ < end;) {
      const std::int64_t middle = (first_narrow_ + end) / 2;
      if (has_parts(width_at(f, static_cast<double>(middle) / kOne))) {
        first_narrow_ = middle + 1;
      } else {
        end = middle;
      }
    }
    const int m = parts(f.samples_per_px);
    for (int k = 0; k < m; ++k) offsets_.push_back(offset_of_part(f.samples_per_px, k, m));
    f.taps = footprint_taps(f.samples_per_px, f.samples);
    f.scale = static_cast<float>(1.0 / m);
    // An odd number of cache lines spreads neighboring beams over the cache.
    f.line = (static_cast<std::size_t>(f.samples + f.taps + 15) / 16 | 1) * 16;
    f.to.resize(pixels);
    f.from.resize(pixels);
    f.beam_fraction.resize(pixels);
    f.sample_weight.resize(pixels * static_cast<std::size_t>(f.taps));
    f.beam_begin.push_back(0);
  }

  void add(std::int32_t to, std::int64_t sample, std::int64_t beam) {
    const bool inside = sample + offsets_.front() >= 0 && sample + offsets_.back() <= last_;
    if (inside && sample >= first_narrow_) {
      add_narrow(to, sample, beam);
    } else {
      add_wide(to, sample, beam, width_at(f_, static_cast<double>(sample) / kOne));
    }
  }

  // Places wide pixels after the narrow ones. All pixels must have been added.
  void finish() {
    ENSONIFY_ASSERT(narrow_ + wide_to_.size() == f_.to.size());
    std::copy(wide_to_.begin(), wide_to_.end(), f_.to.begin() + narrow_);
    std::copy(wide_from_.begin(), wide_from_.end(), f_.from.begin() + narrow_);
    f_.beam_fraction.resize(narrow_);
    f_.sample_weight.resize(narrow_ * static_cast<std::size_t>(f_.taps));
    f_.wide_weight.shrink_to_fit();
    f_.beam_weight.shrink_to_fit();
    f_.beam_begin.shrink_to_fit();
  }

 private:
  std::uint32_t index_of(std::int64_t beam, std::int64_t sample) const {
    return static_cast<std::uint32_t>((beam >> kBits) * static_cast<std::int64_t>(f_.line) +
                                      (sample >> kBits));
  }

  void add_narrow(std::int32_t to, std::int64_t sample, std::int64_t beam) {
    const std::int64_t start = sample + offsets_.front();
    f_.to[narrow_] = to;
    f_.from[narrow_] = index_of(beam, start);
    f_.beam_fraction[narrow_] = static_cast<std::uint16_t>(beam & (kWhole - 1));
    std::uint16_t* weight = f_.sample_weight.data() + narrow_ * static_cast<std::size_t>(f_.taps);
    for (const std::int64_t offset : offsets_) {
      add_weights(sample + offset, start >> kBits, weight);
    }
    ++narrow_;
  }

  void add_wide(std::int32_t to, std::int64_t sample, std::int64_t beam, double width) {
    const auto inside = [&](std::int64_t place) {
      return std::clamp<std::int64_t>(place, 0, last_);
    };
    const std::int64_t start = inside(sample + offsets_.front());
    const std::size_t first = f_.wide_weight.size();
    f_.wide_weight.resize(first + static_cast<std::size_t>(f_.taps));
    for (const std::int64_t offset : offsets_) {
      add_weights(inside(sample + offset), start >> kBits, f_.wide_weight.data() + first);
    }
    const int n = parts(width);
    const auto column = [&](int part) {
      return place_of(static_cast<double>(beam) / kOne + width * middle_of_part(part, n), f_.beams);
    };
    const std::int64_t left = column(0) >> kBits;
    sums_.assign(static_cast<std::size_t>((column(n - 1) >> kBits) - left + 2), 0);
    for (int j = 0; j < n; ++j) add_weights(column(j), left, sums_.data());
    if (sums_.back() == 0) sums_.pop_back();
    for (const std::int64_t sum : sums_) {
      f_.beam_weight.push_back(static_cast<float>(static_cast<double>(sum) / (n * kOne)));
    }
    f_.beam_begin.push_back(static_cast<std::uint32_t>(f_.beam_weight.size()));
    wide_to_.push_back(to);
    wide_from_.push_back(index_of(left << kBits, start));
  }

  Footprints& f_;
  std::int64_t last_;                  // the place of the last sample
  std::int64_t first_narrow_ = 0;      // from here on, footprints are at most one beam wide
  std::size_t narrow_ = 0;             // pixels so far
  std::vector<std::int64_t> offsets_;  // of the parts from the middle
  std::vector<std::int32_t> wide_to_;
  std::vector<std::uint32_t> wide_from_;
  std::vector<std::int64_t> sums_;
};

}  // namespace

bool is_grid_of_fan(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                    const Record& record) {
  constexpr double kSpacingSlack = 1.01, kMostParts = 1e6;
  const double samples_per_px = grid.m_per_px * (2.0 * sonar.bandwidth_hz / water.sound_speed_m_s);
  const double half_fan = std::min(furthest_azimuth_rad(sonar), kPi / 2);
  // The longest edge of a grid in samples: forward and back, or to both sides.
  const double reach = record.samples + 1.0 + sonar.first_range_m / range_step_m(sonar, water);
  const double longest = 2 * kSpacingSlack * reach;
  return sonar.beam_spacing_rad > 0 && samples_per_px > 0 && samples_per_px < kMostParts &&
         grid.height_px * samples_per_px <= longest &&
         (grid.width_px - 2) * samples_per_px <= longest * std::sin(half_fan);
}

int footprint_taps(double samples_per_px, int samples) {
  const int m = parts(samples_per_px);
  const std::int64_t span =
      offset_of_part(samples_per_px, m - 1, m) - offset_of_part(samples_per_px, 0, m);
  const std::int64_t points = std::min<std::int64_t>((span + 2 * kWhole - 1) >> kBits, samples) + 1;
  return static_cast<int>((points + 3) / 4 * 4);
}

Footprints footprints(const CartesianGrid& grid, const Sonar& sonar, const Water& water,
                      const Record& record, std::span<const std::int32_t> map) {
  Footprints f;
  f.grid = grid;
  f.beams = sonar.beam_count;
  f.samples = record.samples;
  f.samples_per_m = 2.0 * sonar.bandwidth_hz / water.sound_speed_m_s;
  f.samples_per_px = grid.m_per_px * f.samples_per_m;
  f.beams_samples_per_px = f.samples_per_px / sonar.beam_spacing_rad;
  f.first_sample = sonar.first_range_m * f.samples_per_m;
  ENSONIFY_ASSERT(map.size() == std::size_t(grid.height_px) * grid.width_px);
  const auto pixels = std::ranges::count_if(map, [](std::int32_t polar) { return polar >= 0; });
  FootprintMaker maker(f, static_cast<std::size_t>(pixels));
  const BeamPlaces beams(sonar);
  PixelSpan span;
  for (std::int32_t row = 0; row < grid.height_px; ++row) {
    const std::int32_t end = (row + 1) * grid.width_px;
    for (std::int32_t to = row * grid.width_px; to < end;) {
      span.to = to;
      while (to < end && to < span.to + kSpan_px && map[to] >= 0) ++to;
      span.count = to - span.to;
      if (span.count == 0) {
        ++to;
        continue;
      }
      place_span(f, span);
      for (int i = 0; i < span.count; ++i) {
        maker.add(span.to + i, static_cast<std::int64_t>(span.sample[i]), beams.at(span, i));
      }
    }
  }
  maker.finish();
  return f;
}

double sample_place(const Footprints& f, std::int32_t pixel) {
  const double x = x_of_row(f.grid, pixel / f.grid.width_px),
               y = y_of_column(f.grid, pixel % f.grid.width_px);
  return std::floor(unrounded_place(sample_position(f, x, y), f.samples));
}

}  // namespace ensonify
