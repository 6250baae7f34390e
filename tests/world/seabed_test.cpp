#include "world/terrain.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <set>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

// 64 x 64 vertices that are one whole period of 16 m, so that its waves can be told apart exactly.
HeightfieldSpec rough_square(double cell_m = 0.25) {
  HeightfieldSpec spec;
  spec.size_m = {16 - cell_m, 16 - cell_m};
  spec.cell_m = cell_m;
  spec.roughness = RoughnessSpec{0.05, 3.2, 8};
  return spec;
}
constexpr double kPeriod_m = 16;

// (1/N) sum of h exp(-i K x) for K = 2 pi (m, n) / period, x from the north-west corner to the
// east, y to the south; m and n from -most to most.
std::vector<std::complex<double>> coefficients(const HeightGrid& grid, int most) {
  const int width = 2 * most + 1;
  const auto turn = [&](int m, int i) {
    return std::polar(1.0, -2 * kPi * m * i * grid.cell_m / kPeriod_m);
  };
  std::vector<std::complex<double>> rows(std::size_t(grid.rows) * width), all(width * width);
  for (int r = 0; r < grid.rows; ++r) {
    for (int m = -most; m <= most; ++m) {
      for (int c = 0; c < grid.columns; ++c) {
        rows[std::size_t(r) * width + m + most] +=
            grid.heights_m[std::size_t(r) * grid.columns + c] * turn(m, c);
      }
    }
  }
  for (int n = -most; n <= most; ++n) {
    for (int r = 0; r < grid.rows; ++r) {
      for (int m = 0; m < width; ++m) {
        all[std::size_t(n + most) * width + m] += rows[std::size_t(r) * width + m] * turn(n, r);
      }
    }
  }
  for (auto& c : all) c /= grid.heights_m.size();
  return all;
}

double mean_square(const HeightGrid& grid) {
  double sum = 0;
  for (const double h : grid.heights_m) sum += h * h;
  return sum / static_cast<double>(grid.heights_m.size());
}

// The formula of the documentation, written a second time.
double spectrum(const RoughnessSpec& r, double k) {
  const double k0 = 2 * kPi / r.outer_scale_m;
  return r.rms_m * r.rms_m * (r.exponent - 2) / (2 * kPi) * std::pow(k0, r.exponent - 2) /
         std::pow(k * k + k0 * k0, r.exponent / 2);
}

// Expected power of each wave of the square that is drawn, and its K^2 + K0^2; half of the plane.
struct Wave {
  std::size_t place;
  double power, scale;
};
std::vector<Wave> waves_of(const RoughnessSpec& r, int most) {
  const double step = 2 * kPi / kPeriod_m, k0 = 2 * kPi / r.outer_scale_m;
  std::vector<Wave> waves;
  for (int n = -most; n <= most; ++n) {
    for (int m = -most; m <= most; ++m) {
      if (n < 0 || (n == 0 && m <= 0)) continue;
      const double k = step * std::hypot(m, n);
      if (k >= kPi / 0.25) continue;
      waves.push_back({std::size_t(n + most) * (2 * most + 1) + m + most,
                       spectrum(r, k) * step * step, k * k + k0 * k0});
    }
  }
  return waves;
}

}  // namespace

// Protects the level of roughness: its power over all wave vectors is the square of rms.
TEST_CASE("the spectrum's integral is the mean square") {
  for (const double exponent : {2.5, 3.0, 4.0}) {
    const RoughnessSpec roughness{0.3, exponent, 5};
    // Of K = K0 tan(t), the integrand goes to zero at the end; by the midpoint rule.
    const double outer = 2 * kPi / 5;
    double sum = 0;
    const int steps = 200000;
    for (int i = 0; i < steps; ++i) {
      const double t = (i + 0.5) / steps * kPi / 2;
      const double k = outer * std::tan(t);
      sum += roughness_spectrum(roughness, k) * 2 * kPi * k * outer / std::pow(std::cos(t), 2);
    }
    // With 2.5 the end still holds (K0/K)^0.5 of the whole in the last steps: 0.2 %.
    CHECK(sum * kPi / 2 / steps == Approx(0.09).epsilon(3e-3));
    CHECK(roughness_spectrum(roughness, 3) == Approx(spectrum(roughness, 3)));
  }
}

// Protects rms, exponent and outer scale at once: 20 seeds, each wave's power against the closed
// form. |c|^2 is exponentially distributed: over W waves the mean ratio has the standard error
// 1/sqrt(W); the logarithm has the variance pi^2/6 and the slope over x the error
// sqrt(pi^2 / 6 / Sxx).
TEST_CASE("procedural roughness has the spectrum asked for") {
  const HeightfieldSpec spec = rough_square();
  const std::vector<Wave> waves = waves_of(*spec.roughness, 31);
  REQUIRE(waves.size() > 1500);
  const int seeds = 20;
  double expected = 0, variance = 0, found = 0, ratio = 0;
  for (const Wave& wave : waves) {
    expected += 2 * wave.power;
    variance += 4 * wave.power * wave.power / seeds;
  }
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const HeightGrid grid = make_seabed(spec, terrain_key(seed, 0, "seabed"));
    REQUIRE(grid.rows == 64);
    found += mean_square(grid) / seeds;
    const auto c = coefficients(grid, 31);
    for (const Wave& wave : waves) {
      const double power = std::norm(c[wave.place]);
      ratio += power / wave.power;
      const double x = -0.5 * std::log(wave.scale), y = std::log(power);
      sx += x;
      sy += y;
      sxx += x * x;
      sxy += x * y;
    }
  }
  const double count = static_cast<double>(waves.size()) * seeds;
  const double spread = sxx - sx * sx / count;
  const double exponent = (sxy - sx * sy / count) / spread;
  const double exponent_error = std::sqrt(kPi * kPi / 6 / spread);
  INFO("mean square " << found << " of " << expected << " +- " << std::sqrt(variance)
                      << ", exponent " << exponent << " +- " << exponent_error << ", ratio "
                      << ratio / count << " +- " << 1 / std::sqrt(count));
  CHECK(std::abs(found - expected) < 3 * std::sqrt(variance));
  CHECK(std::abs(exponent - 3.2) < 3 * exponent_error);
  CHECK(exponent_error < 0.02);
  CHECK(std::abs(ratio / count - 1) < 3 / std::sqrt(count));
  // What the square does not hold: waves longer than it and shorter than two cells.
  CHECK(expected == Approx(0.05 * 0.05).epsilon(0.2));
}

// Protects the choice of cell from changing the seabed: the same waves, and shorter ones.
TEST_CASE("halving the cell keeps every wave and adds shorter ones") {
  const std::uint64_t key = terrain_key(1, 2, "seabed");
  const auto coarse = coefficients(make_seabed(rough_square(0.25), key), 31);
  const auto fine = coefficients(make_seabed(rough_square(0.125), key), 31);
  for (const Wave& wave : waves_of(*rough_square().roughness, 31)) {
    CHECK(std::abs(coarse[wave.place] - fine[wave.place]) < 1e-9 * std::sqrt(wave.power));
  }
}

TEST_CASE("keys of terrain differ by seed, sequence and name") {
  std::set<std::uint64_t> keys;
  for (const char* name : {"", "a", "b", "ab", "ba"}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      for (std::uint32_t sequence = 0; sequence < 4; ++sequence) {
        keys.insert(terrain_key(seed, sequence, name));
      }
    }
  }
  CHECK(keys.size() == 5 * 4 * 4);
}

// Protects strips: a period as long as the outer scale across them too, or the waves along them
// would be too high.
TEST_CASE("a narrow strip is as rough as a square") {
  HeightfieldSpec strip;
  strip.size_m = {64, 1};
  strip.cell_m = 0.5;
  strip.roughness = RoughnessSpec{0.1, 3.5, 8};
  CHECK(roughness_period(strip) == std::array<std::int64_t, 2>{256, 16});
  double found = 0;
  const int seeds = 100;
  for (int seed = 0; seed < seeds; ++seed) {
    found += mean_square(make_seabed(strip, terrain_key(seed, 0, "strip"))) / seeds;
  }
  // About 8 independent stretches of an outer scale each a seed: standard error 5 %, and 8 % of
  // the power are in waves that are too short or too long for the lattice.
  CHECK(found == Approx(0.01).epsilon(0.2));
}

namespace {

// |sum of h exp(-i K x)| under a Hann window, K by wavelength and direction.
double response(const HeightGrid& grid, double wavelength_m, double direction_deg) {
  const double k = 2 * kPi / wavelength_m;
  const double kx = k * std::cos(radians(direction_deg)), ky = k * std::sin(radians(direction_deg));
  std::complex<double> sum;
  double weights = 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const double weight = std::pow(std::sin(kPi * (row + 0.5) / grid.rows), 2) *
                            std::pow(std::sin(kPi * (column + 0.5) / grid.columns), 2);
      weights += weight;
      sum += std::polar(weight * grid.heights_m[std::size_t(row) * grid.columns + column],
                        -kx * column_x_m(grid, column) - ky * row_y_m(grid, row));
    }
  }
  return std::abs(sum) / weights;
}

}  // namespace

// Protects the ripples' wavelength, direction and height: the spectrum's peak lies where it should,
// with the amplitude of a trochoid's first harmonic, a (J0(e) - J2(e)) / 2 on either side of zero.
TEST_CASE("ripples have the wavelength, direction and height asked for", "[figure]") {
  HeightfieldSpec spec;
  spec.size_m = {12, 10};
  spec.cell_m = 0.1;
  spec.ripples = {{0.12, 0.8, 30}};
  const HeightGrid grid = make_seabed(spec, terrain_key(4, 0, "sand"));
  double most = 0, wavelength_m = 0, direction_deg = 0;
  for (double w = 0.7; w < 0.92; w += 0.01) {
    for (double d = -90; d < 90; d += 2) {
      const double power = response(grid, w, d);
      if (power > most) std::tie(most, wavelength_m, direction_deg) = std::tuple(power, w, d);
    }
  }
  CHECK(wavelength_m == Approx(0.8).margin(0.006));
  CHECK(direction_deg == Approx(30).margin(1));
  const double a = 0.06, e = a * 2 * kPi / 0.8;
  CHECK(response(grid, 0.8, 30) ==
        Approx(a * (std::cyl_bessel_j(0, e) - std::cyl_bessel_j(2, e)) / 2).epsilon(1e-3));
  const auto [low, high] = std::minmax_element(grid.heights_m.begin(), grid.heights_m.end());
  CHECK(*high - *low == Approx(0.12).epsilon(1e-3));
  CHECK(*high > -*low);  // sharp crests, wide troughs: the mean lies nearer to the troughs
  double mean = 0;
  for (const double h : grid.heights_m) mean += h / static_cast<double>(grid.heights_m.size());
  CHECK(mean == Approx(0).margin(2e-3));
}

TEST_CASE("ripples are laid over roughness and over each other") {
  HeightfieldSpec both = rough_square();
  both.ripples = {{0.05, 2, 0}, {0.02, 1.5, 120}};
  HeightfieldSpec rough = rough_square(), ripples = both;
  ripples.roughness.reset();
  const std::uint64_t key = 7;
  const HeightGrid sum = make_seabed(both, key), a = make_seabed(rough, key),
                   b = make_seabed(ripples, key);
  for (std::size_t i = 0; i < sum.heights_m.size(); i += 17) {
    CHECK(sum.heights_m[i] == Approx(a.heights_m[i] + b.heights_m[i]).margin(1e-12));
  }
}
