#include "world/cover.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

HeightGrid flat_grid(int columns, int rows, double cell_m, double height_m = 0) {
  return {rows, columns, cell_m, std::vector<double>(std::size_t(rows) * columns, height_m)};
}

StoneSpec boulders() {
  StoneSpec stones;
  stones.density_per_m2 = 0.7;
  stones.diameter_m = {0.3, 2};
  stones.exponent = 2.5;
  return stones;
}

}  // namespace

// Protects the Poisson process: the mean and the variance of the number of centers in a square,
// over seeds. The variance of the sample variance of n Poisson counts of mean m is about 2 m^2 / n.
TEST_CASE("stones are a Poisson process of the density asked for") {
  const int seeds = 400;
  const double mean = 0.7 * 20 * 20;
  double sum = 0, squares = 0;
  std::array<double, 4> quadrant{};
  for (int seed = 0; seed < seeds; ++seed) {
    double count = 0;
    for (const Stone& stone : stones_within(boulders(), terrain_key(seed, 0, "bed"), 0, {10, 10})) {
      if (std::abs(stone.x_m) > 10 || std::abs(stone.y_m) > 10) continue;
      ++count;
      ++quadrant[(stone.x_m > 0) + 2 * (stone.y_m > 0)];
    }
    sum += count;
    squares += count * count;
  }
  const double found = sum / seeds, variance = squares / seeds - found * found;
  CHECK(std::abs(found - mean) < 3 * std::sqrt(mean / seeds));
  CHECK(std::abs(variance - mean) < 3 * mean * std::sqrt(2.0 / seeds));
  const double quarter = mean * seeds / 4;
  for (const double n : quadrant) CHECK(std::abs(n - quarter) < 3 * std::sqrt(quarter));
}

// Protects sizes and shapes: the Kolmogorov-Smirnov distance of the diameters to their
// distribution, whose bound of 1.95 / sqrt(n) is exceeded by chance once in a thousand draws; the
// means of uniform values; no direction preferred.
TEST_CASE("stones have the sizes and shapes asked for") {
  const StoneSpec spec = boulders();
  std::vector<double> diameters;
  double aspect = 0, height = 0, buried = 0, cosine = 0;
  for (const Stone& stone : stones_within(spec, 42, 1, {100, 100})) {
    if (std::abs(stone.x_m) > 100 || std::abs(stone.y_m) > 100)
      continue;  // larger ones reach farther
    diameters.push_back(stone.diameter_m);
    aspect += stone.aspect;
    height += stone.height_m / stone.diameter_m;
    buried += stone.buried_fraction;
    cosine += std::cos(2 * stone.yaw_rad);
    REQUIRE(stone.aspect <= 1);
    REQUIRE(stone.aspect >= 0.6);
  }
  std::sort(diameters.begin(), diameters.end());
  const double n = static_cast<double>(diameters.size());
  REQUIRE(n > 20000);
  const double tail = std::pow(2.0, -2.5);
  double distance = 0;
  for (std::size_t i = 0; i < diameters.size(); ++i) {
    const double expected =
        (std::pow(0.3, -2.5) - std::pow(diameters[i], -2.5)) / (std::pow(0.3, -2.5) - tail);
    distance = std::max({distance, std::abs(expected - static_cast<double>(i) / n),
                         std::abs(expected - static_cast<double>(i + 1) / n)});
  }
  CHECK(distance < 1.95 / std::sqrt(n));
  CHECK(diameters.front() >= 0.3);
  CHECK(diameters.back() <= 2);
  const double of_uniform = 0.4 / std::sqrt(12 * n);  // standard error over a range of 0.4
  CHECK(std::abs(aspect / n - 0.8) < 3 * of_uniform);
  CHECK(std::abs(height / n - 0.6) < 3 * of_uniform);
  CHECK(std::abs(buried / n - 0.5) < 3 * of_uniform);
  CHECK(std::abs(cosine / n) < 3 / std::sqrt(2 * n));
}

// Protects stones from the extent: a larger bed has the same ones, and more.
TEST_CASE("stones do not depend on the size of the bed") {
  const auto small = stones_within(boulders(), 7, 0, {6, 4});
  const auto large = stones_within(boulders(), 7, 0, {20, 30});
  REQUIRE(small.size() > 50);
  CHECK(large.size() > small.size());
  for (const Stone& stone : small) {
    const auto same = [&](const Stone& other) {
      return other.x_m == stone.x_m && other.y_m == stone.y_m &&
             other.diameter_m == stone.diameter_m && other.yaw_rad == stone.yaw_rad;
    };
    CHECK(std::count_if(large.begin(), large.end(), same) == 1);
  }
}

// Protects the shape: top and surface of an ellipsoid by its own equation, nothing beside it.
TEST_CASE("a stone is the upper side of an ellipsoid") {
  const Stone stone{3, -2, 1.2, 0.5, radians(30), 0.8, 0.25};
  CHECK(*stone_height_m(stone, 3, -2) == Approx(0.75 * 0.8));
  const double center_m = (0.5 - 0.25) * 0.8;
  for (const double along : {-0.4, 0.0, 0.3}) {
    for (const double across : {-0.1, 0.2}) {
      const double x = 3 + along * std::cos(radians(30)) - across * std::sin(radians(30));
      const double y = -2 + along * std::sin(radians(30)) + across * std::cos(radians(30));
      const auto height = stone_height_m(stone, x, y);
      REQUIRE(height);
      CHECK(std::pow(along / 0.6, 2) + std::pow(across / 0.3, 2) +
                std::pow((*height - center_m) / 0.4, 2) ==
            Approx(1));
      CHECK(*height > center_m);
    }
  }
  CHECK_FALSE(
      stone_height_m(stone, 3 - 0.31 * std::sin(radians(30)), -2 + 0.31 * std::cos(radians(30))));
}

// Protects laying: heights of the surface over the bed under each center, the highest of several,
// wherever two cells have a point in common; factors where a stone is to be seen, and only there.
TEST_CASE("stones lie on the bed, the same ones at half the cell") {
  std::vector<StoneSpec> populations = {boulders(), boulders()};
  populations[1].reflectivity_db = 10;
  const double bed = 1.5;
  HeightGrid coarse = flat_grid(81, 61, 0.125, bed), fine = flat_grid(161, 121, 0.0625, bed);
  std::vector<float> factors, fine_factors;
  lay_stones(populations, 99, coarse, factors);
  lay_stones(populations, 99, fine, fine_factors);
  std::vector<Stone> stones[2];
  for (std::size_t k = 0; k < 2; ++k) stones[k] = stones_within(populations[k], 99, k, {5, 3.75});
  std::size_t bright = 0, dark = 0;
  for (int row = 0; row < coarse.rows; ++row) {
    for (int column = 0; column < coarse.columns; ++column) {
      double highest = 0, factor = 1;
      for (std::size_t k = 0; k < 2; ++k) {
        for (const Stone& stone : stones[k]) {
          const auto height =
              stone_height_m(stone, column_x_m(coarse, column), row_y_m(coarse, row));
          if (height && *height > highest) highest = *height, factor = k == 1 ? 10 : 1;
        }
      }
      const std::size_t at = std::size_t(row) * coarse.columns + column;
      const std::size_t same = std::size_t(2 * row) * fine.columns + 2 * column;
      REQUIRE(coarse.heights_m[at] == Approx(bed + highest).epsilon(1e-12));
      REQUIRE(fine.heights_m[same] == Approx(coarse.heights_m[at]).epsilon(1e-12));
      REQUIRE(factors[at] == Approx(factor));
      REQUIRE(fine_factors[same] == factors[at]);
      (factor > 1 ? bright : dark) += highest > 0;
    }
  }
  CHECK(bright > 200);
  CHECK(dark > 200);
}

TEST_CASE("stones without a reflectivity of their own bring no factors, and holes stay") {
  HeightGrid grid = flat_grid(61, 61, 0.1);
  for (int row = 0; row < 61; ++row) {
    for (int column = 0; column < 30; ++column) {
      grid.heights_m[row * 61 + column] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  std::vector<float> factors;
  lay_stones({boulders()}, 3, grid, factors);
  CHECK(factors.empty());
  double highest = 0;
  for (int row = 0; row < 61; ++row) {
    CHECK(std::isnan(grid.heights_m[row * 61 + 29]));
    for (int column = 30; column < 61; ++column) {
      highest = std::max(highest, grid.heights_m[row * 61 + column]);
    }
  }
  CHECK(highest > 0.05);
}

TEST_CASE("the quantile inverts the standard normal distribution") {
  CHECK(standard_normal_quantile(0.5) == Approx(0).margin(1e-12));
  CHECK(standard_normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-12));
  CHECK(standard_normal_quantile(0.01) == Approx(-2.326347874040841).epsilon(1e-12));
  CHECK(standard_normal_quantile(1) > 8);
}

namespace {

// Variance of the share of a large area A above a level t: 2 pi l^2 / A times the integral over
// u = r^2 / (2 l^2) of the covariance of two indicators of the correlation e^-u, which is the
// integral of exp(-t^2 / (1 + s)) / (2 pi sqrt(1 - s^2)) over s from 0 to e^-u.
double share_variance(double t, double correlation_m, double area_m2) {
  const auto covariance = [&](double rho) {  // s = sin(a)
    double sum = 0;
    const int steps = 200;
    const double most = std::asin(rho);
    for (int i = 0; i < steps; ++i) {
      const double a = (i + 0.5) * most / steps;
      sum += std::exp(-t * t / (1 + std::sin(a))) / (2 * kPi) * most / steps;
    }
    return sum;
  };
  double integral = 0;
  for (double u = 0.005; u < 15; u += 0.01) integral += 0.01 * covariance(std::exp(-u));
  return 2 * kPi * correlation_m * correlation_m * integral / area_m2;
}

}  // namespace

// Protects threshold and border: the share within the middles of the borders is the one asked for,
// and the borders take the area that follows from Rice's formula for the length of a level line per
// area, exp(-t^2 / 2) / (2 l), times their width. In a border of 0.15 l a line bends by its own
// width seldom: 4 % are allowed for it.
TEST_CASE("patches cover their share, with borders of the width asked for") {
  // At t = 0 the variance has a closed form of its own.
  CHECK(share_variance(0, 2, 50) == Approx(kPi * std::log(2) / 2 * 4 / 50).epsilon(2e-3));
  const HeightGrid grid = flat_grid(401, 401, 0.25);
  for (const double share : {0.5, 0.2}) {
    const PatchSpec patch{share, 2, 0.3, 6, 1};
    const double t = standard_normal_quantile(1 - share);
    const int seeds = 12;
    double inside = 0, border = 0;
    for (int seed = 0; seed < seeds; ++seed) {
      for (const float w : patch_weights(patch, terrain_key(seed, 0, "bed"), 0, grid)) {
        inside += w > 0.5;
        border += w > 0 && w < 1;
      }
    }
    const double points = 401.0 * 401 * seeds;
    const double error = std::sqrt(share_variance(t, 2, 1e4) / seeds);
    INFO(inside / points << " of " << share << " +- " << error);
    CHECK(error < 0.03 * share);
    CHECK(std::abs(inside / points - share) < 3 * error);
    CHECK(border / points == Approx(0.3 * std::exp(-t * t / 2) / (2 * 2)).epsilon(0.04));
  }
}

// Protects the covariance by the normal field's orthant probability: two points at a distance r are
// on the same side of the median with the probability 1/2 + asin(rho) / pi.
TEST_CASE("patches have the correlation length asked for") {
  const HeightGrid grid = flat_grid(401, 401, 0.5);
  const PatchSpec patch{0.5, 2, 0, 6, 1};
  for (const int step : {2, 4, 6}) {
    double same = 0, pairs = 0;
    for (int seed = 0; seed < 6; ++seed) {
      const auto w = patch_weights(patch, terrain_key(seed, 1, "bed"), 3, grid);
      for (int row = 0; row + step < 401; ++row) {
        for (int column = 0; column + step < 401; ++column) {
          const std::size_t at = std::size_t(row) * 401 + column;
          same += (w[at] == w[at + step]) + (w[at] == w[at + std::size_t(step) * 401]);
          pairs += 2;
        }
      }
    }
    const double r = 0.5 * step, rho = std::exp(-r * r / (2 * 2 * 2));
    CHECK(same / pairs == Approx(0.5 + std::asin(rho) / kPi).margin(0.01));
  }
}

TEST_CASE("patches stay where they are at half the cell and on a larger bed") {
  const PatchSpec patch{0.3, 1.5, 0.4, 6, 1};
  const HeightGrid coarse = flat_grid(41, 61, 0.25), fine = flat_grid(161, 161, 0.125);
  const auto a = patch_weights(patch, 5, 0, coarse), b = patch_weights(patch, 5, 0, fine);
  const auto other = patch_weights(patch, 5, 1, coarse);
  std::size_t differ = 0;
  for (int row = 0; row < 61; ++row) {
    for (int column = 0; column < 41; ++column) {
      const std::size_t at = std::size_t(row) * 41 + column;
      const int fine_row = 80 + 2 * (row - 30), fine_column = 80 + 2 * (column - 20);
      CHECK(std::abs(a[at] - b[std::size_t(fine_row) * 161 + fine_column]) < 1e-4);
      differ += std::abs(a[at] - other[at]) > 0.5;
    }
  }
  CHECK(differ > 100);
}

// Protects factors: mixed by area over the border, later patches over earlier ones and over a map.
TEST_CASE("the reflectivity of patches mixes with what is below") {
  const std::vector<PatchSpec> patches = {{0.5, 2, 1, 10, 1}, {0.4, 1, 0.5, -10, 1}};
  const HeightGrid grid = flat_grid(101, 101, 0.2);
  std::vector<float> factors(grid.heights_m.size(), 3), none;
  lay_patches(patches, 11, grid, factors);
  const auto first = patch_weights(patches[0], 11, 0, grid);
  const auto second = patch_weights(patches[1], 11, 1, grid);
  for (std::size_t i = 0; i < factors.size(); i += 7) {
    const double below = (1 - first[i]) * 3.0 + first[i] * 10.0;
    CHECK(factors[i] == Approx((1 - second[i]) * below + second[i] * 0.1).epsilon(1e-5));
  }
  lay_patches({{0.5, 2, 1, 0, 3}}, 11, grid, none);
  CHECK(none.empty());
}

// Protects the relief: ripples and short waves are scaled within patches, and the long waves, which
// would make steps at the borders, are left.
TEST_CASE("the relief factor scales what is shorter than the patches") {
  HeightfieldSpec plain;
  plain.size_m = {15.75, 15.75};  // a whole period of 16 m
  plain.cell_m = 0.25;
  plain.roughness = RoughnessSpec{0.1, 3, 8};
  HeightfieldSpec ripples = plain, scaled;
  ripples.roughness.reset();
  ripples.ripples = {{0.05, 1.5, 20}};
  scaled = ripples;
  scaled.patches = {{0.5, 2, 0.5, 0, 0.25}};
  const std::uint64_t key = 21;
  const HeightGrid a = make_seabed(ripples, key), b = make_seabed(scaled, key);
  const auto weights = patch_weights(scaled.patches[0], key, 0, a);
  for (std::size_t i = 0; i < a.heights_m.size(); ++i) {
    CHECK(b.heights_m[i] == Approx(a.heights_m[i] * (1 - 0.75 * weights[i])).margin(1e-12));
  }
  HeightfieldSpec rough = plain;
  rough.patches = {{1, 2, 0, 0, 3}};  // patches everywhere: the waves alone are seen
  const HeightGrid c = make_seabed(plain, key), d = make_seabed(rough, key);
  for (const int wave : {2, 6, 12}) {  // 8 m; 2.7 m; 1.3 m
    for (const bool across : {false, true}) {
      const auto amplitude = [&](const HeightGrid& grid) {
        std::complex<double> sum;
        for (int row = 0; row < grid.rows; ++row) {
          for (int column = 0; column < grid.columns; ++column) {
            sum += std::polar(grid.heights_m[std::size_t(row) * grid.columns + column],
                              -2 * kPi * wave * (across ? row : column) / 64);
          }
        }
        return sum;
      };
      const std::complex<double> before = amplitude(c), after = amplitude(d);
      CHECK(std::abs(after - (wave == 12 ? 3.0 : 1.0) * before) < 1e-9 * std::abs(before));
    }
  }
}
