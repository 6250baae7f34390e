#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <limits>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "world/cover.h"
#include "world/terrain.h"

namespace ensonify {
namespace {

// Values of several series at once, so that operations of a series need not wait for each other and
// columns of a lattice are read by whole cache lines.
constexpr std::size_t kSeries = 8;
struct Values {
  double re[kSeries] = {}, im[kSeries] = {};
};

// The passes of FourierSum over series whose values are in reversed order.
ENSONIFY_VECTOR_CLONES void sum_in_passes(const std::complex<double>* __restrict turns,
                                          std::size_t length, Values* __restrict data) {
  for (std::size_t half = 1; half < length; half *= 2) {
    const std::size_t stride = length / (2 * half);
    for (std::size_t start = 0; start < length; start += 2 * half) {
      for (std::size_t j = 0; j < half; ++j) {
        const double c = turns[j * stride].real(), s = turns[j * stride].imag();
        Values &even = data[start + j], &odd = data[start + j + half];
        for (std::size_t i = 0; i < kSeries; ++i) {
          const double re = odd.re[i] * c - odd.im[i] * s, im = odd.re[i] * s + odd.im[i] * c;
          odd.re[i] = even.re[i] - re;
          odd.im[i] = even.im[i] - im;
          even.re[i] += re;
          even.im[i] += im;
        }
      }
    }
  }
}

// x[j] = sum over k of X[k] exp(+2 pi i j k / n), not normalized, in place. A simple
// implementation, so that terrain has the same bits on every processor and shares no planner with
// the synthesis.
class FourierSum {
 public:
  // The length is a power of two.
  explicit FourierSum(std::size_t length) : turns_(length / 2), reversed_(length) {
    ENSONIFY_ASSERT(std::has_single_bit(length) && length >= 2);
    for (std::size_t j = 0; j < turns_.size(); ++j) {
      const double angle = 2 * kPi * static_cast<double>(j) / static_cast<double>(length);
      turns_[j] = {std::cos(angle), std::sin(angle)};
    }
    for (std::size_t i = 1; i < length; ++i) {
      reversed_[i] = reversed_[i / 2] / 2 + (i % 2 ? static_cast<std::uint32_t>(length / 2) : 0);
    }
  }

  void run(std::vector<Values>& data) const {
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (i < reversed_[i]) std::swap(data[i], data[reversed_[i]]);
    }
    sum_in_passes(turns_.data(), data.size(), data.data());
  }

 private:
  std::vector<std::complex<double>> turns_;  // exp(2 pi i j / n), j < n / 2
  std::vector<std::uint32_t> reversed_;      // indices with their bits in reverse order
};

using Waves = std::vector<std::complex<double>>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// First words of the draws' counters.
enum Draw : std::uint32_t { roughness_wave = 0, ripple_phase = 1 };

// Lattice indices from -n/2 + 1 to n/2 are in the order of the transform.
std::int64_t lattice_index(std::int64_t place, std::int64_t period) {
  return place <= period / 2 ? place : place - period;
}

// The amplitudes of waves [period[1] / 2 + 1][period[0] / 2 + 1] by the size of their indices; 0
// for those that are left out. Each wave has twice its power, because only the real part of the
// complex sum is kept. Wave numbers begin at `lowest`.
std::vector<double> wave_amplitudes(const RoughnessSpec& roughness, double cell_m, double lowest,
                                    std::array<std::int64_t, 2> period) {
  const double step_x = 2 * kPi / (static_cast<double>(period[0]) * cell_m);
  const double step_y = 2 * kPi / (static_cast<double>(period[1]) * cell_m);
  const double highest = kPi / cell_m;
  std::vector<double> amplitudes;
  for (std::int64_t n = 0; n <= period[1] / 2; ++n) {
    for (std::int64_t m = 0; m <= period[0] / 2; ++m) {
      const double wave_number =
          std::hypot(step_x * static_cast<double>(m), step_y * static_cast<double>(n));
      const bool has_wave = wave_number > 0 && wave_number >= lowest && wave_number < highest;
      amplitudes.push_back(
          has_wave ? std::sqrt(2 * roughness_spectrum(roughness, wave_number) * step_x * step_y)
                   : 0);
    }
  }
  return amplitudes;
}

Waves draw_waves(const RoughnessSpec& roughness, std::uint64_t key, double cell_m, double lowest,
                 std::array<std::int64_t, 2> period) {
  const std::vector<double> amplitudes = wave_amplitudes(roughness, cell_m, lowest, period);
  Waves waves(static_cast<std::size_t>(period[0] * period[1]));
  for (std::int64_t row = 0; row < period[1]; ++row) {
    for (std::int64_t column = 0; column < period[0]; ++column) {
      const std::int64_t m = lattice_index(column, period[0]), n = lattice_index(row, period[1]);
      const double amplitude =
          amplitudes[static_cast<std::size_t>(std::abs(n) * (period[0] / 2 + 1) + std::abs(m))];
      if (amplitude == 0) continue;
      const std::uint64_t item =
          std::uint64_t{static_cast<std::uint32_t>(m)} << 32 | static_cast<std::uint32_t>(n);
      const ComplexDraw draw = complex_normal(key, roughness_wave, item, 0);
      waves[static_cast<std::size_t>(row * period[0] + column)] = {amplitude * draw.re,
                                                                   amplitude * draw.im};
    }
  }
  return waves;
}

void add_roughness(const HeightfieldSpec& spec, std::uint64_t key, double lowest,
                   HeightGrid& grid) {
  const std::array<std::int64_t, 2> period = roughness_period(spec);
  const auto columns = static_cast<std::size_t>(period[0]);
  const auto rows = static_cast<std::size_t>(period[1]);
  Waves waves = draw_waves(*spec.roughness, key, grid.cell_m, lowest, period);
  const FourierSum along_x(columns), along_y(rows);
  std::vector<Values> values(rows);
  for (std::size_t first = 0; first < columns; first += kSeries) {
    const std::size_t count = std::min(kSeries, columns - first);
    const auto each = [&](auto&& use) {
      for (std::size_t row = 0; row < rows; ++row) {
        std::complex<double>* at = waves.data() + row * columns + first;
        for (std::size_t i = 0; i < count; ++i) use(at[i], values[row].re[i], values[row].im[i]);
      }
    };
    each([](const auto& wave, double& re, double& im) { re = wave.real(), im = wave.imag(); });
    along_y.run(values);
    each([](auto& wave, double re, double im) { wave = {re, im}; });
  }
  // The north-west corner is the origin of the waves for every cell size.
  values.assign(columns, {});
  const auto wanted = static_cast<std::size_t>(grid.rows);
  for (std::size_t first = 0; first < wanted; first += kSeries) {
    const std::size_t count = std::min(kSeries, wanted - first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::complex<double>* row = waves.data() + (first + i) * columns;
      for (std::size_t column = 0; column < columns; ++column) {
        values[column].re[i] = row[column].real();
        values[column].im[i] = row[column].imag();
      }
    }
    along_x.run(values);
    for (std::size_t i = 0; i < count; ++i) {
      double* heights = grid.heights_m.data() + (first + i) * std::size_t(grid.columns);
      for (int column = 0; column < grid.columns; ++column) {
        heights[column] += values[static_cast<std::size_t>(column)].re[i];
      }
    }
  }
}

// Solves theta - e sin theta = phase for theta, with 0 <= e < 1. Newton's method starts at pi and
// decreases monotonically, because the function is convex there.
double trochoid_angle(double phase, double e) {
  const double folded = std::abs(std::remainder(phase, 2 * kPi));
  double theta = kPi;
  for (int step = 0; step < 50; ++step) {
    const double change = (theta - e * std::sin(theta) - folded) / (1 - e * std::cos(theta));
    theta -= change;
    if (std::abs(change) < 1e-12) break;
  }
  return theta;  // of the folded phase: the profile is even
}

void add_ripples(const RippleSpec& ripple, std::uint64_t key, std::uint64_t number,
                 HeightGrid& grid) {
  const double wave_number = 2 * kPi / ripple.wavelength_m;
  const double kx = wave_number * std::cos(radians(ripple.direction_deg));
  const double ky = wave_number * std::sin(radians(ripple.direction_deg));
  const double amplitude_m = ripple.height_m / 2;
  const double e = amplitude_m * wave_number;
  const double phase = 2 * kPi * uniform(key, ripple_phase, number, 0);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const double angle =
          trochoid_angle(phase + kx * column_x_m(grid, column) + ky * row_y_m(grid, row), e);
      grid.heights_m[std::size_t(row) * grid.columns + column] +=
          amplitude_m * (std::cos(angle) + e / 2);
    }
  }
}

HeightGrid flat(const HeightfieldSpec& spec) {
  const auto [columns, rows] = vertices_along(spec);
  return {rows, columns, spec.cell_m, std::vector<double>(std::size_t(rows) * columns)};
}

// Ripples, and roughness with wave numbers of at least `lowest`.
HeightGrid relief_from(const HeightfieldSpec& spec, std::uint64_t key, double lowest) {
  HeightGrid grid = flat(spec);
  if (spec.roughness) add_roughness(spec, key, lowest, grid);
  for (std::size_t i = 0; i < spec.ripples.size(); ++i) add_ripples(spec.ripples[i], key, i, grid);
  return grid;
}

// Long waves are not scaled, because that would cause a step at the border of a patch.
void scale_relief(const HeightfieldSpec& spec, std::uint64_t key, HeightGrid& grid) {
  double shortest_m = kInfinite;
  bool differs = false;
  for (const PatchSpec& patch : spec.patches) {
    shortest_m = std::min(shortest_m, patch.correlation_m);
    differs |= patch.relief_factor != 1;
  }
  if (!differs) return;
  const HeightGrid fine = relief_from(spec, key, 2 * kPi / shortest_m);
  std::vector<double> factors(grid.heights_m.size(), 1);
  for (std::size_t k = 0; k < spec.patches.size(); ++k) {
    const std::vector<float> weights = patch_weights(spec.patches[k], key, k, grid);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      factors[i] += weights[i] * (spec.patches[k].relief_factor - factors[i]);
    }
  }
  for (std::size_t i = 0; i < factors.size(); ++i) {
    grid.heights_m[i] += (factors[i] - 1) * fine.heights_m[i];
  }
}

}  // namespace

std::uint64_t terrain_key(std::uint64_t seed, SequenceDraw draw, std::string_view object) {
  return mix64(stream_key(seed, Stream::terrain, draw) ^ name_key(object));
}

double roughness_spectrum(const RoughnessSpec& roughness, double wave_number_rad_m) {
  const double g = roughness.exponent;
  const double outer = 2 * kPi / roughness.outer_scale_m;
  const double square = 1 + std::pow(wave_number_rad_m / outer, 2);
  return roughness.rms_m * roughness.rms_m * (g - 2) / (2 * kPi * outer * outer) *
         std::pow(square, -g / 2);
}

HeightGrid make_seabed(const HeightfieldSpec& spec, std::uint64_t key) {
  HeightGrid grid = relief_from(spec, key, 0);
  scale_relief(spec, key, grid);
  return grid;
}

}  // namespace ensonify
