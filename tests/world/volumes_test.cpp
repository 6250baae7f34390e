// Procedural volumes: plumes and schools.
#include "world/volumes.h"
#include "scenario/scenario.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "world/world.h"

using namespace ensonify;

namespace {

const PlumeSpec kPlume{0.3, 4, 8, -20, 3};

double density_of(const DensityGrid& grid, Vec3 p) {
  return density_at(grid, mapped(grid.index_from_local, p));
}

}  // namespace

// Protects the extent: nothing outside the cone, but for the voxel that the grid blurs it by, and
// density up to its rim and near its top.
TEST_CASE("a plume fills its cone") {
  const auto grid = make_plume(kPlume, 5);
  REQUIRE(grid.ok());
  const double step = grid->spacing_m;
  CHECK(step <= 0.05);
  double widest = 0, highest = 0;
  for (double z = -0.5; z < 4.6; z += 0.031) {
    for (double x = -1.2; x < 1.2; x += 0.029) {
      for (double y = -1.2; y < 1.2; y += 0.033) {
        const double density = density_of(*grid, {x, y, z});
        if (z < -step || z > 4 + step || std::hypot(x, y) > plume_radius_m(kPlume, z) + 2 * step) {
          REQUIRE(density == 0);
        }
        if (density < 1e-3) continue;
        widest = std::max(widest, std::hypot(x, y) / plume_radius_m(kPlume, z));
        highest = std::max(highest, z);
      }
    }
  }
  CHECK(widest > 0.9);
  CHECK(highest > 3.8);
}

// The mean over 400 keys is the profile: 0.8 of the density's logarithm spreads it by 0.95 of its
// mean, and so the mean of 400 by 0.047; 5 standard errors. On a sample of the grid.
TEST_CASE("turbulence leaves the mean density alone", "[figure]") {
  const PlumeSpec plume{0.5, 2, 10, -20, 0};
  const int draws = 400;
  const double step = 0.5 / 6;
  std::array<Vec3, 3> points = {
      Vec3{0, 0, 4 * step}, {2 * step, 3 * step, 9 * step}, {0, -2 * step, 20 * step}};
  std::array<double, 3> sum{}, square{};
  for (int i = 0; i < draws; ++i) {
    const auto grid = make_plume(plume, mix64(i));
    REQUIRE(grid.ok());
    REQUIRE(grid->spacing_m == Approx(step));
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double density = density_of(*grid, points[k]);
      sum[k] += density / draws;
      square[k] += density * density / draws;
    }
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double mean = plume_mean_density(plume, points[k]);
    CHECK(sum[k] == Approx(mean).epsilon(5 * 0.047));
    // Variance e^(0.64) - 1 = 0.896 of a lognormal's mean square.
    CHECK(square[k] / (mean * mean) == Approx(1.896).epsilon(0.35));
  }
}

TEST_CASE("the plume's profile") {
  CHECK(plume_mean_density(kPlume, {0, 0, 0}) == Approx(1));
  const double radius = 0.3 + 2 * std::tan(radians(8));
  CHECK(plume_radius_m(kPlume, 2) == Approx(radius));
  CHECK(plume_mean_density(kPlume, {0, 0, 2}) == Approx(0.09 / (radius * radius)));
  CHECK(plume_mean_density(kPlume, {radius / 2, 0, 2}) ==
        Approx(0.5625 * 0.09 / (radius * radius)));
  CHECK(plume_mean_density(kPlume, {0, radius, 2}) == 0);
  CHECK(plume_mean_density(kPlume, {0, 0, 4}) == 0);
  CHECK(plume_mean_density(kPlume, {0, 0, -0.01}) == 0);
}

TEST_CASE("a plume too slender at its foot for its grid is refused") {
  const auto grid = make_plume({0.01, 9, 60, -20, 0}, 1);
  REQUIRE_FALSE(grid.ok());
  CHECK(grid.error().kind == ErrorKind::usage);
}

// Uniform in an ellipsoid with half axes a, b, c: <x^2> = a^2/5; 4000 fish, standard error
// sqrt(<x^4> - <x^2>^2)/sqrt(n) = 1.07 <x^2>/63: 5 of them are 8.5 %.
TEST_CASE("fish fill their ellipsoid") {
  const SchoolSpec school{{4, 2, 1}, 4000, -35};
  const Pose pose{{10, 20, 30}, from_roll_pitch_yaw(0, 0, radians(90))};
  const auto fish = fish_of(school, pose, 9);
  REQUIRE(fish.size() == 4000);
  Vec3 mean, square;
  for (const Vec3& f : fish) {
    const Vec3 p = f - Vec3{10, 20, 30};  // turned: x across, y along
    REQUIRE(p.x * p.x + p.y * p.y / 4 + p.z * p.z * 4 <= 1 + 1e-12);
    mean = mean + (1.0 / 4000) * p;
    square = square + (1.0 / 4000) * Vec3{p.x * p.x, p.y * p.y, p.z * p.z};
  }
  CHECK(length(mean) < 5 * std::sqrt((4 + 1 + 0.25) / 5 / 4000));
  CHECK(square.x == Approx(1.0 / 5).epsilon(0.085));
  CHECK(square.y == Approx(4.0 / 5).epsilon(0.085));
  CHECK(square.z == Approx(0.25 / 5).epsilon(0.085));
  // More fish leave the others where they are.
  const auto fewer = fish_of({{4, 2, 1}, 10, -35}, pose, 9);
  for (int i = 0; i < 10; ++i) CHECK(fewer[i] == fish[i]);
}

// Protects instances and keys: one instance a volume, in the order of the scenario; what is drawn
// goes with seed, sequence and name, not with the place in the list.
TEST_CASE("the volumes of a world") {
  Scenario scenario;
  scenario.seed = 4;
  scenario.volumes = {{"a", "school", SchoolSpec{{1, 1, 1}, 5, -30}, {}},
                      {"b", "box", UniformVolumeSpec{-50, {{2, 4, 6}}, 0.5}, {{1, 2, 3}, {}}},
                      {"c", "school", SchoolSpec{{1, 1, 1}, 5, -30}, {}}};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  REQUIRE(world->schools.size() == 2);
  REQUIRE(world->volumes.size() == 1);
  CHECK(world->schools[0].instance == 1);
  CHECK(world->volumes[0].instance == 2);
  CHECK(world->schools[1].instance == 3);
  CHECK(world->instances[0].kind == InstanceKind::volume);
  CHECK(world->instances[0].volume_strength_db == Approx(-30 + 10 * std::log10(5 / (kPi / 6))));
  CHECK(world->volumes[0].strength_per_m == Approx(1e-5));
  CHECK(world->volumes[0].extinction_db_m == 0.5);
  CHECK(world->volumes[0].pose.position_m == Vec3{1, 2, 3});
  CHECK(std::get<DensityBox>(world->volumes[0].density).half_extents_m == Vec3{1, 2, 3});
  CHECK_FALSE(world->schools[0].fish_m[0] == world->schools[1].fish_m[0]);
  const auto fish = [](Scenario s, std::uint32_t sequence) {
    return build_world(s, sequence)->schools.back().fish_m[0];
  };
  const Vec3 before = fish(scenario, 0);
  CHECK_FALSE(fish(scenario, 1) == before);
  scenario.volumes.erase(scenario.volumes.begin());
  CHECK(fish(scenario, 0) == before);
  scenario.seed = 5;
  CHECK_FALSE(fish(scenario, 0) == before);
}

TEST_CASE("all broken volumes are told at once") {
  Scenario scenario;
  scenario.volumes = {{"a", "v", VdbVolumeSpec{"none.vdb", "density", -20, 0}, {}},
                      {"b", "v", UniformVolumeSpec{}, {}},
                      {"c", "v", PlumeSpec{0.01, 9, 60, -20, 0}, {}}};
  const auto world = build_world(scenario);
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().kind == ErrorKind::usage);
  CHECK(world.error().message.starts_with("volumes.0.vdb.file: none.vdb: "));
  CHECK(world.error().message.find("\nvolumes.2.plume.radius_m: too small") != std::string::npos);
}
