// Random fields over surfaces: their distributions against the laws that they claim, and their
// correlation, by sums over many places.
#include "world/surface_field.h"

#include <cmath>
#include <vector>

#include "catch.h"

using namespace ensonify;

namespace {

// Far apart: one place in each of many cells of a field, over several fields.
std::vector<double> samples(const SurfaceTexture& texture, int fields) {
  std::vector<double> values;
  for (int k = 0; k < fields; ++k) {
    const auto field = make_texture(texture, 100 + k);
    for (int x = 0; x < 12; ++x) {
      for (int y = 0; y < 12; ++y) {
        for (int z = 0; z < 12; ++z) {
          values.push_back(
              double{field->at(4.7 * texture.correlation_m * Vec3{1.0 * x, 1.0 * y, 1.0 * z})});
        }
      }
    }
  }
  return values;
}

struct Moments {
  double mean = 0, variance = 0, error_of_mean = 0, error_of_variance = 0;
};

Moments moments_of(const std::vector<double>& values) {
  Moments m;
  const auto n = static_cast<double>(values.size());
  double fourth = 0;
  for (const double v : values) m.mean += v / n;
  for (const double v : values) m.variance += (v - m.mean) * (v - m.mean) / n;
  for (const double v : values) fourth += std::pow(v - m.mean, 4) / n;
  m.error_of_mean = std::sqrt(m.variance / n);
  m.error_of_variance = std::sqrt((fourth - m.variance * m.variance) / n);
  return m;
}

}  // namespace

TEST_CASE("textures have mean 1 and the variance of their law") {
  for (const double shape : {0.5, 2.0, 10.0}) {
    const Moments m = moments_of(samples({TextureModel::gamma, shape, 0, 0.1}, 8));
    CHECK(std::abs(m.mean - 1) < 3.5 * m.error_of_mean);
    CHECK(std::abs(m.variance - 1 / shape) < 3.5 * m.error_of_variance);
    CHECK(m.error_of_variance < 0.15 / shape);
  }
  const double spread_db = 3, sigma = spread_db * std::log(10.0) / 10;
  std::vector<double> levels;
  for (const double v : samples({TextureModel::lognormal, 1, spread_db, 0.1}, 8)) {
    levels.push_back(10 * std::log10(v));
  }
  const Moments m = moments_of(levels);
  CHECK(std::abs(m.mean + 10 * sigma * sigma / 2 / std::log(10.0)) < 3.5 * m.error_of_mean);
  CHECK(std::abs(m.variance - spread_db * spread_db) < 3.5 * m.error_of_variance);
}

TEST_CASE("the logarithm of a lognormal texture has its correlation length", "[figure]") {
  const double length = 0.2;
  double product = 0, square = 0, far = 0;
  for (int k = 0; k < 30; ++k) {
    const auto field = make_texture({TextureModel::lognormal, 1, 3, length}, 7 + k);
    const double sigma = 3 * std::log(10.0) / 10;
    const auto gaussian = [&](Vec3 p) {
      return (std::log(double{field->at(p)}) + sigma * sigma / 2) / sigma;
    };
    for (int i = 0; i < 3000; ++i) {
      const Vec3 p{0.37 * i, -0.21 * i, 0.53 * (i % 100)};
      const double g = gaussian(p);
      square += g * g;
      product += g * gaussian(p + Vec3{length / std::sqrt(3.0), length / std::sqrt(3.0),
                                       length / std::sqrt(3.0)});
      far += g * gaussian(p + Vec3{0, 4 * length, 0});
    }
  }
  // Not the same in all directions: along a diagonal of the lattice it falls faster.
  CHECK(product / square == Approx(1 / std::exp(1.0)).margin(0.15));
  CHECK(std::abs(far / square) < 0.05);
}

TEST_CASE("growth covers its share, and a field is fixed by its key") {
  double covered = 0;
  int count = 0;
  for (int k = 0; k < 20; ++k) {
    const auto growth = make_growth(0.3, 0.05, 50 + k);
    for (int i = 0; i < 500; ++i, ++count) {
      const float value = growth->at({0.31 * i, 0.17 * i, -0.23 * (i % 50)});
      covered += double{value};
    }
  }
  CHECK(covered / count == Approx(0.3).margin(0.03));
  const SurfaceTexture texture{TextureModel::gamma, 2, 0, 0.1};
  CHECK(make_texture(texture, 3)->at({1, 2, 3}) == make_texture(texture, 3)->at({1, 2, 3}));
  CHECK(make_texture(texture, 3)->at({1, 2, 3}) != make_texture(texture, 4)->at({1, 2, 3}));
}
