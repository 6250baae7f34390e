#include <cmath>

#include "catch.h"
#include "temporary_folder.h"
#include "trace/tracer.h"
#include "write_vdb.h"

using namespace ensonify;
using namespace ensonify::test;

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
