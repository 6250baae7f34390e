#include "trace/even_points.h"

#include <algorithm>
#include <complex>
#include <memory>
#include <numbers>
#include <utility>

#include "acoustics/pattern.h"
#include "acoustics/pulse.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr std::int64_t kPatternSide = EvenPattern::kSide;
constexpr std::size_t kPlaces = kPatternSide * kPatternSide;

// Power spectrum of the pattern's density, relative to that of independent places, at 0.05, 0.15,
// ... per spacing. It is about 1 beyond.
constexpr std::array kNoise = {0.0,  0.0,  0.0,  0.0,  0.001, 0.003, 0.017, 0.13,
                               0.66, 1.73, 2.55, 1.77, 1.15,  0.73,  0.61,  0.57,
                               0.55, 0.69, 0.92, 1.23, 1.43,  1.34,  1.22,  1.0};

double noise_at(double per_spacing) {
  const double place = per_spacing * 10 - 0.5;
  if (place <= 0) return kNoise.front();
  const auto i = static_cast<std::size_t>(place);
  if (i + 1 >= kNoise.size()) return 1;
  return std::lerp(kNoise[i], kNoise[i + 1], place - static_cast<double>(i));
}

// A spatial frequency and the power that beam or pulse leave of it, as a share, times the step
// between frequencies.
struct Tone {
  double per_m = 0, power_per_m = 0;
};

// Of the pulse over range: at most kBins frequencies from 0 on.
std::vector<Tone> tones_of_pulse(const Sonar& sonar, const Water& water, int transform) {
  constexpr std::size_t kBins = 64;
  const auto spectrum = pulse_spectrum(sonar, transform);
  const std::size_t count = spectrum.size(), step = (count + kBins - 1) / kBins;
  const double bin_per_m = 2 * sonar.bandwidth_hz / static_cast<double>(count) /
                           water.sound_speed_m_s * static_cast<double>(step);
  std::vector<Tone> tones;
  double energy = 0;
  for (std::size_t k = 0; k < count; k += step) {
    std::complex<double> sum = 0;
    for (std::size_t m = 0; m + k < count; ++m) sum += spectrum[m + k] * std::conj(spectrum[m]);
    if (k == 0) energy = std::abs(sum);
    tones.push_back({static_cast<double>(tones.size()) * bin_per_m,
                     std::norm(sum) / (energy * energy) * bin_per_m});
  }
  tones.front().power_per_m /= 2;
  return tones;
}

// Of a beam whose -3 dB width is 1: that of an even line of elements, in steps as wide as beam
// cells, `cell` of its width.
std::vector<Tone> tones_of_beam(double cell) {
  constexpr int kBins = 192;
  constexpr double kReach = 0.8859;  // the spectrum of sinc^2 ends here
  // The steps repeat the spectrum, less of it each time.
  const double end = 4.5 / cell, step = end / kBins;
  std::vector<Tone> tones;
  for (int i = 0; i < kBins; ++i) {
    const double f = i * step, apart = std::abs(std::remainder(f * cell, 1.0)) / cell;
    const double left = sinc(f * cell) * std::max(0.0, 1 - apart / kReach);
    tones.push_back({f, left * left * (i == 0 ? step / 2 : step)});
  }
  return tones;
}

// Rms error of the level with places of that spacing, in dB.
double error_db(double spacing_m, double width_m, std::span<const Tone> pulse,
                std::span<const Tone> beam) {
  double sum = 0;
  for (const Tone& along : pulse) {
    for (const Tone& across : beam) {
      const double f = std::hypot(along.per_m, across.per_m / width_m);
      sum += noise_at(f * spacing_m) * along.power_per_m * across.power_per_m / width_m;
    }
  }
  // Four quadrants.
  return 10 / std::numbers::ln10 * spacing_m * std::sqrt(4 * sum);
}

double longest_spacing(double width_m, std::span<const Tone> pulse, std::span<const Tone> beam,
                       double low_m, double high_m) {
  constexpr int kHalvings = 12;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low_m * high_m);
    (error_db(middle, width_m, pulse, beam) <= kPlacesErrorDb ? low_m : high_m) = middle;
  }
  return low_m;
}

// Points that repel one another, in a square that repeats.
class Repulsion {
 public:
  Repulsion() {
    // An additive sequence of low discrepancy (Roberts 2018), with jitter that hides its lattice.
    constexpr double kPlastic = 1.32471795724474602596, kJitter = 1.5;
    constexpr std::uint64_t kKey = 1;
    for (std::uint32_t i = 0; i < kPlaces; ++i) {
      const Philox4 words = random_words(kKey, 0, i, 0);
      const auto start = [&](double step, std::uint32_t word) {
        const double x = i * step;
        return wrapped(kPatternSide * (x - std::floor(x)) +
                       kJitter * (uniform_from_word(word) - 0.5));
      };
      places_[i] = {start(1 / kPlastic, words.v[0]), start(1 / (kPlastic * kPlastic), words.v[1])};
    }
    sort();
  }

  void relax() {
    constexpr double kStep = 0.5;
    std::array<EvenPlace, kPlaces> moved;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const EvenPlace push = push_on(places_[i]);
      moved[i] = {wrapped(places_[i].x + kStep * push.x), wrapped(places_[i].y + kStep * push.y)};
    }
    places_ = moved;
    sort();
  }

  EvenPattern pattern() const { return {places_, first_}; }

 private:
  static double wrapped(double x) {
    x -= kPatternSide * std::floor(x / kPatternSide);
    return x < kPatternSide ? x : 0;
  }

  EvenPlace push_on(const EvenPlace& here) const {
    // (1 - d^2/32 s^2)^16 is nearly exp(-d^2/2 s^2), s = 0.7, in the same arithmetic everywhere.
    constexpr double kScale = 1 / (32 * 0.7 * 0.7), kReach = 2.6;
    constexpr std::int64_t kCells = 3;
    EvenPlace push;
    const auto x = static_cast<std::int64_t>(here.x), y = static_cast<std::int64_t>(here.y);
    for (std::int64_t j = y - kCells; j <= y + kCells; ++j) {
      for (std::int64_t i = x - kCells; i <= x + kCells; ++i) {
        const auto cell = static_cast<std::size_t>((j & (kPatternSide - 1)) * kPatternSide +
                                                   (i & (kPatternSide - 1)));
        for (std::size_t k = first_[cell]; k < first_[cell + 1]; ++k) {
          const double dx = here.x - places_[k].x -
                            static_cast<double>(i - (i & (kPatternSide - 1))),
                       dy = here.y - places_[k].y -
                            static_cast<double>(j - (j & (kPatternSide - 1)));
          const double squared = dx * dx + dy * dy;
          if (squared > kReach * kReach) continue;
          double weight = 1 - squared * kScale;
          for (int power = 1; power < 16; power *= 2) weight *= weight;
          push.x += weight * dx;
          push.y += weight * dy;
        }
      }
    }
    return push;
  }

  // By cell; within one, in the order before.
  void sort() {
    const auto cell_of = [](const EvenPlace& p) {
      return static_cast<std::size_t>(static_cast<std::int64_t>(p.y) * kPatternSide +
                                      static_cast<std::int64_t>(p.x));
    };
    first_.fill(0);
    for (const EvenPlace& place : places_) ++first_[cell_of(place) + 1];
    for (std::size_t i = 0; i < kPlaces; ++i) {
      first_[i + 1] = static_cast<std::uint16_t>(first_[i + 1] + first_[i]);
    }
    std::ranges::stable_sort(places_, {}, cell_of);
  }

  std::array<EvenPlace, kPlaces> places_;
  std::array<std::uint16_t, kPlaces + 1> first_;
};

EvenPattern make_pattern() {
  constexpr int kSteps = 60;
  const auto points = std::make_unique<Repulsion>();
  for (int i = 0; i < kSteps; ++i) points->relax();
  return points->pattern();
}

// Of an axis counted cyclically.
double cyclic_component(Vec3 v, int axis) {
  const int which = axis % 3;
  return which == 0 ? v.x : which == 1 ? v.y : v.z;
}

void include(double x, double y, EvenPlane& plane) {
  plane.low = {std::min(plane.low[0], x), std::min(plane.low[1], y)};
  plane.high = {std::max(plane.high[0], x), std::max(plane.high[1], y)};
}

}  // namespace

double EvenSpacing::at(double width_m) const {
  const double place = 2 * std::log2(std::max(width_m / least_width_m, 1.0));
  const double last = static_cast<double>(spacing_m.size() - 1);
  if (place >= last) return spacing_m.back();
  const auto i = static_cast<std::size_t>(place);
  return std::lerp(spacing_m[i], spacing_m[i + 1], place - static_cast<double>(i));
}

EvenSpacing even_spacing(const Sonar& sonar, const Water& water, int transform) {
  constexpr int kWidths = 12;
  const std::vector<Tone> pulse = tones_of_pulse(sonar, water, transform);
  const std::vector<Tone> beam =
      tones_of_beam(std::max(sonar.beam_spacing_rad / sonar.beam_width_rad, 0.15));
  const double pulse_m = water.sound_speed_m_s * pulse_width_s(sonar, transform) / 2;
  EvenSpacing even{pulse_m / 4, {}};
  double width_m = even.least_width_m;
  for (int i = 0; i < kWidths; ++i) {
    even.spacing_m.push_back(longest_spacing(width_m, pulse, beam, pulse_m / 64, 1.5 * pulse_m));
    width_m *= std::numbers::sqrt2;
  }
  return even;
}

const EvenPattern& even_pattern() {
  static const EvenPattern pattern = make_pattern();
  return pattern;
}

int even_scale(double spacing_m) { return static_cast<int>(std::ceil(-4 * std::log2(spacing_m))); }

double even_spacing_of(int scale) { return std::exp2(-scale / 4.0); }

EvenPlane even_plane(const RectanglePatch& patch) {
  EvenPlane plane;
  plane.normal = normalized(cross(patch.u, patch.v));
  for (int axis = 0; axis < 3; ++axis) {
    if (cyclic_component(plane.normal, axis) != 0) plane.axis = axis;
  }
  plane.lift = {cyclic_component(patch.corner, plane.axis), 0, 0};
  for (const Vec3 corner : {patch.corner, patch.corner + patch.u + patch.v}) {
    include(cyclic_component(corner, plane.axis + 1), cyclic_component(corner, plane.axis + 2),
            plane);
  }
  return plane;
}

EvenPlane even_plane(const TrianglePatch& patch, int axis) {
  EvenPlane plane;
  plane.axis = axis;
  plane.normal = normalized(cross(patch.b - patch.a, patch.c - patch.a));
  plane.is_triangle = true;
  std::array<std::array<double, 2>, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 corner = i == 0 ? patch.a : i == 1 ? patch.b : patch.c;
    corners[i] = {cyclic_component(corner, axis + 1), cyclic_component(corner, axis + 2)};
    include(corners[i][0], corners[i][1], plane);
  }
  const double along = cyclic_component(plane.normal, axis), side = along < 0 ? -1 : 1;
  const double by_x = -cyclic_component(plane.normal, axis + 1) / along,
               by_y = -cyclic_component(plane.normal, axis + 2) / along;
  plane.lift = {cyclic_component(patch.a, axis) - by_x * corners[0][0] - by_y * corners[0][1], by_x,
                by_y};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [x, y] = corners[i];
    const auto [next_x, next_y] = corners[(i + 1) % 3];
    plane.edges[i] = {-side * (next_y - y), side * (next_x - x),
                      side * (x * (next_y - y) - y * (next_x - x))};
  }
  return plane;
}

}  // namespace ensonify
