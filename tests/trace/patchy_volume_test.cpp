// Patchy volumes: random densities along rays and in the energy of samples, against closed forms.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "acoustics/propagation.h"
#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"
#include "trace/volume.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kCell_m = 0.025;  // c/2b

Sonar pencil_sonar(double range_max_m) {
  Sonar sonar = test::fan_sonar(1, radians(0.5), range_max_m, 1, radians(0.5));
  sonar.bandwidth_hz = 30e3;
  return sonar;
}

Volume patchy(const SurfaceTexture& patches, std::uint64_t key, DensityField density = {},
              Pose pose = {}) {
  Volume volume{1, 1e-4, 0, std::move(density), pose};
  volume.patches = make_texture(patches, key);
  volume.patch_m = patches.correlation_m;
  return volume;
}

std::vector<float> sample_energy(const Sonar& sonar, const Volume& volume, const Pose& pose = {}) {
  const Fan fan = make_fan(sonar);
  const std::vector<Hit> open(fan.size());
  return volume_echoes(fan, open, {volume}, pose, sonar, kWater, make_record(sonar, kWater, 0),
                       Workers(2))[0]
      .energy;
}

Pose any_pose(std::uint64_t i) {
  const auto word = [&](std::uint32_t k) { return uniform(11, 0, i, k); };
  return {{90 * word(0), 90 * word(1), 90 * word(2)},
          from_roll_pitch_yaw(0, std::asin(2 * word(3) - 1), 2 * kPi * word(4))};
}

struct PatchMoments {
  double mean = 0, variance = 0, error_of_mean = 0, error_of_variance = 0;
};

PatchMoments patch_moments(const std::vector<double>& values) {
  PatchMoments m;
  const auto n = static_cast<double>(values.size());
  double fourth = 0;
  m.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  for (const double v : values) m.variance += (v - m.mean) * (v - m.mean) / n;
  for (const double v : values) fourth += std::pow(v - m.mean, 4) / n;
  m.error_of_mean = std::sqrt(m.variance / n);
  m.error_of_variance = std::sqrt((fourth - m.variance * m.variance) / n);
  return m;
}

// The energy of samples over that without patches, for samples that are `apart` cells from each
// other, on rays anywhere in fields of several keys.
std::vector<double> energy_ratios(const SurfaceTexture& patches, int keys, int rays, int apart) {
  const Sonar sonar = pencil_sonar(8);
  const std::vector<float> even = sample_energy(sonar, {1, 1e-4});
  std::vector<double> ratios;
  for (int k = 0; k < keys; ++k) {
    const Volume volume = patchy(patches, 30 + k);
    for (int i = 0; i < rays; ++i) {
      const auto energy = sample_energy(sonar, volume, any_pose(1000 * k + i));
      for (std::size_t n = 40; n < even.size(); n += apart) {
        if (even[n] > 0) ratios.push_back(double{energy[n]} / double{even[n]});
      }
    }
  }
  return ratios;
}

// The mean product of the field's deviations at two places that far apart in any direction.
double covariance_at(const SurfaceTexture& patches, double distance_m) {
  double sum = 0;
  constexpr int kFields = 8, kPairs = 20'000;
  for (int k = 0; k < kFields; ++k) {
    const auto field = make_texture(patches, 500 + k);
    for (int i = 0; i < kPairs; ++i) {
      const Pose pose = any_pose(100'000 * k + i);
      const Vec3 along = rotate(pose.rotation, {distance_m, 0, 0});
      sum += (double{field->at(pose.position_m)} - 1) *
             (double{field->at(pose.position_m + along)} - 1);
    }
  }
  return sum / (kFields * kPairs);
}

}  // namespace

// The integral over a step against one of 200 points of the field itself: the rest is what lies
// between the points that the ray looks at.
TEST_CASE("steps of a ray hold the integral of the patches") {
  const Pose pose{{3, -2, 1}, from_roll_pitch_yaw(0.2, 0.4, 0.6)};
  const Ray ray{{0.4, 0.1, 0.2}, unit_vector(0.3, -0.2)};
  DensityColumn column;
  for (const double correlation_m : {0.02, 0.1, 1.0}) {
    const Volume volume = patchy({TextureModel::lognormal, 1, 3, correlation_m}, 4, {}, pose);
    constexpr double kStep_m = 0.0125;
    march(volume, ray, kStep_m, 10, column);
    REQUIRE(column.last == 800);
    double square = 0;
    for (int k = 0; k < 800; ++k) {
      double mean = 0;
      for (int i = 0; i < 200; ++i) {
        const Vec3 p = ray.origin_m + ((k + (i + 0.5) / 200) * kStep_m) * ray.direction;
        mean += double{volume.patches->at(inverse_transform_point(pose, p))} / 200;
      }
      square += std::pow(column.length_m[k] / kStep_m / mean - 1, 2) / 800;
    }
    CHECK(std::sqrt(square) < 0.02);
  }
}

// Protects boxes: the same field as without an end, and nothing outside, to within the partial
// steps at the faces.
TEST_CASE("patches in a box are those of the whole water") {
  const SurfaceTexture patches{TextureModel::gamma, 2, 0, 0.5};
  const Volume open = patchy(patches, 5), box = patchy(patches, 5, DensityBox{{2, 5, 5}});
  DensityColumn everywhere, inside;
  const Ray ray{{-4.5, 0.3, 0.1}, {1, 0, 0}};  // inside from 2.5 m to 6.5 m
  march(open, ray, 0.0125, 10, everywhere);
  march(box, ray, 0.0125, 10, inside);
  CHECK(inside.first == 200);
  CHECK(inside.last == 520);
  for (int k = 200; k < 520; ++k) {
    REQUIRE(inside.length_m[k] == Approx(everywhere.length_m[k]).epsilon(1e-9));
  }
  march(box, ray, 0.0125, 4, inside);
  CHECK(inside.last == 320);
  march(box, {{-4.5, 6, 0}, {1, 0, 0}}, 0.0125, 10, inside);
  CHECK(inside.first == inside.last);
}

// Mean 1: patches change no mean level. 2400 samples at least, several correlation lengths apart.
TEST_CASE("the mean energy of a patchy volume is that of an even one", "[figure]") {
  for (const SurfaceTexture& patches : {SurfaceTexture{TextureModel::gamma, 1, 0, 0.1},
                                        SurfaceTexture{TextureModel::lognormal, 1, 4, 0.1}}) {
    const PatchMoments m = patch_moments(energy_ratios(patches, 20, 40, 30));
    CHECK(m.error_of_mean < 0.02);
    CHECK(std::abs(m.mean - 1) < 3.5 * m.error_of_mean);
  }
}

// Var E_n / <E_n>^2 = (1/L^2) int int C(|x - y|) dx dy over the cell's length L: 1/nu times the
// average of the correlation, which a cell far below the correlation length leaves at 1/nu.
TEST_CASE("the variance of a sample is 1/nu times the mean correlation over its cell", "[figure]") {
  const SurfaceTexture coarse{TextureModel::gamma, 2, 0, 1}, fine{TextureModel::gamma, 2, 0, 0.02};
  const PatchMoments whole = patch_moments(energy_ratios(coarse, 20, 200, 160));
  CHECK(whole.error_of_variance < 0.05);
  CHECK(std::abs(whole.variance - 0.5) < 3.5 * whole.error_of_variance);
  // Simpson's rule for (2/L^2) int (L - d) C(d) dd.
  constexpr int kParts = 8;
  double mean = 0;
  for (int i = 0; i <= kParts; ++i) {
    const double share = double(i) / kParts, factor = i == 0 || i == kParts ? 1 : i % 2 ? 4 : 2;
    mean += factor / (3.0 * kParts) * 2 * (1 - share) * covariance_at(fine, share * kCell_m);
  }
  const PatchMoments part = patch_moments(energy_ratios(fine, 20, 100, 9));
  CHECK(mean < 0.4);
  CHECK(mean > 0.15);
  CHECK(part.error_of_variance < 0.02 * mean);
  CHECK(part.variance == Approx(mean).epsilon(0.05));
}

// The logarithm of lognormal energies is the normal field. In any direction the lattice makes it
// fall a little faster than along its axes.
TEST_CASE("energies decorrelate to 1/e at the correlation length") {
  const SurfaceTexture patches{TextureModel::lognormal, 1, 3, 1};
  const Sonar sonar = pencil_sonar(8);
  const std::vector<float> even = sample_energy(sonar, {1, 1e-4});
  const double sigma = 3 * std::log(10.0) / 10;
  const int lag = static_cast<int>(std::lround(1 / kCell_m));
  double product = 0, square = 0;
  for (int k = 0; k < 20; ++k) {
    const Volume volume = patchy(patches, 80 + k);
    for (int i = 0; i < 60; ++i) {
      const auto energy = sample_energy(sonar, volume, any_pose(1000 * k + i));
      const auto level = [&](std::size_t n) {
        return std::log(double{energy[n]} / double{even[n]}) + sigma * sigma / 2;
      };
      for (std::size_t n = 30; n + lag < even.size() && even[n + lag] > 0; n += 40) {
        square += level(n) * level(n);
        product += level(n) * level(n + lag);
      }
    }
  }
  CHECK(product / square == Approx(1 / std::exp(1.0)).margin(0.08));
}

// Sound crosses many patches, so the loss is the mean one, however the density varies.
TEST_CASE("patches attenuate as their mean density does") {
  Volume volume = patchy({TextureModel::gamma, 1, 0, 0.4}, 6);
  volume.extinction_db_m = 2;
  DensityColumn column;
  const Ray ray{{1, 2, 3}, unit_vector(1, 0.2)};
  march(volume, ray, 0.0125, 6, column);
  const double length_m = std::accumulate(column.length_m.begin(), column.length_m.end(), 0.0);
  CHECK(std::abs(length_m - 6) > 0.1);
  CHECK(extinction_db({volume}, ray, 0.0125, 6, column) == Approx(2 * 6));
}

TEST_CASE("patches are fixed by seed, sequence and name") {
  Scenario scenario;
  const auto density = [&](const char* name, std::uint64_t seed, std::uint32_t sequence) {
    scenario.seed = seed;
    UniformVolumeSpec spec{-60, {}, 0, SurfaceTexture{TextureModel::gamma, 2, 0, 0.5}};
    scenario.volumes = {{name, "water", spec, {}}};
    const auto world = build_world(scenario, sequence);
    REQUIRE(world.ok());
    CHECK(world->instances[0].volume_patches.shape == 2);
    return world->volumes[0].patches->at({1, 2, 3});
  };
  const float first = density("a", 1, 0);
  CHECK(density("a", 1, 0) == first);
  CHECK(density("b", 1, 0) != first);
  CHECK(density("a", 2, 0) != first);
  CHECK(density("a", 1, 1) != first);
}
