#include "world/terrain.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "temporary_folder.h"
#include "trace/plain_world.h"
#include "trace/tracer.h"
#include "write_vdb.h"

using namespace ensonify::test;
using namespace ensonify;

namespace {

World terrain(const HeightGrid& grid, Normals normals, const Pose& pose = {}) {
  return world_with(MeshShape{std::make_shared<const Mesh>(heightfield_mesh(grid, normals))}, pose);
}

constexpr double kSlopeX = 0.2, kSlopeY = -0.35, kLevel_m = -4;

HeightGrid tilted_plane() {
  HeightGrid grid{81, 121, 0.25, std::vector<double>(81 * 121)};
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      grid.heights_m[std::size_t(row) * grid.columns + column] =
          kLevel_m + kSlopeX * column_x_m(grid, column) + kSlopeY * row_y_m(grid, row);
    }
  }
  return grid;
}

}  // namespace

// Protects range and incidence over terrain: against the plane's own formula, through any pose.
TEST_CASE("a tilted height grid is hit like its plane") {
  const HeightGrid grid = tilted_plane();
  const Pose pose{{300, -200, 7}, from_roll_pitch_yaw(0.2, -0.1, 2)};
  const Vec3 normal = normalized(Vec3{-kSlopeX, -kSlopeY, 1});
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const World world = terrain(grid, normals, pose);
    const Tracer tracer(world);
    for (std::uint64_t i = 0; i < 2000; ++i) {
      // From above towards a point of the plane.
      const double x = 28 * (uniform(3, 0, i, 0) - 0.5), y = 18 * (uniform(3, 0, i, 1) - 0.5);
      const Vec3 to{x, y, kLevel_m + kSlopeX * x + kSlopeY * y};
      const Vec3 from{30 * (uniform(3, 0, i, 2) - 0.5), 20 * (uniform(3, 0, i, 3) - 0.5), 6};
      const Vec3 start = transform_point(pose, from), aim = transform_point(pose, to);
      const Hit hit = tracer.first_hit({start, normalized(aim - start)}, 100);
      REQUIRE(hit.instance == 1);
      CHECK(std::abs(hit.range_m - length(to - from)) < 1e-5);
      CHECK(hit.cos_incidence == Approx(std::abs(dot(normal, normalized(to - from)))).margin(1e-5));
    }
  }
}

// Protects coasts and gaps in surveys: a ray passes a hole, and nothing lies beyond the edges.
TEST_CASE("rays pass holes and edges") {
  HeightGrid grid{9, 9, 1, std::vector<double>(81, -5)};
  grid.heights_m[4 * 9 + 4] = std::nan("");
  const World world = terrain(grid, Normals::smooth);
  const Tracer tracer(world);
  const auto hits = [&](double x, double y) {
    return tracer.first_hit({{x, y, 0}, {0, 0, -1}}, 100).instance == 1;
  };
  CHECK_FALSE(hits(0.2, 0.2));
  CHECK_FALSE(hits(-0.2, -0.2));
  CHECK(hits(0.7, 0.7));
  CHECK(hits(-1.2, 0.3));
  CHECK(hits(3.9, -3.9));
  CHECK_FALSE(hits(4.1, 0));
  CHECK_FALSE(hits(0, -4.1));
}

// Protects what the sonar meets: ranges and incidences of the level set are those of the closed
// form, to a tenth of a voxel along the normal and a voxel's turn of the sphere.
TEST_CASE("rays meet a level set where they meet its sphere") {
  constexpr double kRadius = 0.5, kVoxel = 0.05;
  const TemporaryFolder folder;
  const auto file = folder.path() / "ball.vdb";
  write_vdb(file, {vdb_sphere(kRadius, kVoxel)});
  PoseSpec pose;
  pose.position_m = {4, 0.3, -0.2};
  pose.rotation = std::array<double, 3>{20, 30, 40};
  Scenario solid, exact;
  solid.materials = exact.materials = {{"m", 1, {}, {}}};
  solid.objects = {{"a", "x", "m", LevelSetSpec{file, "", true}, pose}};
  exact.objects = {{"a", "x", "m", SphereSpec{kRadius, false}, pose}};
  const auto solid_world = build_world(solid), exact_world = build_world(exact);
  REQUIRE((solid_world.ok() && exact_world.ok()));
  const Tracer from_vdb(*solid_world), closed_form(*exact_world);
  int met = 0;
  for (double az = -0.2; az < 0.3; az += 0.005) {
    for (double el = -0.2; el < 0.1; el += 0.005) {
      const Ray ray{{}, unit_vector(az, el)};
      const Hit expected = closed_form.first_hit(ray, 10), hit = from_vdb.first_hit(ray, 10);
      if (expected.instance == 0 || expected.cos_incidence < 0.2) continue;
      ++met;
      REQUIRE(hit.instance == 1);
      REQUIRE(std::abs(hit.range_m - expected.range_m) * expected.cos_incidence < 0.1 * kVoxel);
      REQUIRE(dot(hit.normal, expected.normal) > std::cos(kVoxel / kRadius));
    }
  }
  CHECK(met > 1000);
}
