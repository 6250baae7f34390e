#include "trace/packets.h"

#include <cmath>

#include "catch.h"
#include "core/scatterers.h"
#include "crowded_world.h"

using namespace ensonify;

namespace {

struct Difference {
  int rays = 0, met = 0, differing = 0;
};

// The hits of a fan against those of its rays one by one.
Difference difference_to_single_rays(const World& world, const Fan& fan, const Pose& pose,
                                     double range_max_m, int packet) {
  const Tracer tracer(world);
  Scene scene;
  build_scene(world, own_poses(world), build_hierarchies(world), scene);
  const std::vector<Hit> hits = fan_tracer(packet)(scene, fan, pose, range_max_m, Workers(2));
  REQUIRE(hits.size() == fan.size());
  Difference difference;
  std::size_t i = 0;
  for (const double azimuth : fan.azimuth_rad) {
    for (const double elevation : fan.elevation_rad) {
      const Vec3 direction = normalized(rotate(pose.rotation, unit_vector(azimuth, elevation)));
      const Hit one = tracer.first_hit({pose.position_m, direction}, range_max_m);
      ++difference.rays;
      difference.met += one.instance != 0;
      difference.differing += !same_hit(hits[i++], one);
    }
  }
  return difference;
}

}  // namespace

// Protects every hit against the company that its ray is traced in: the same surface, and the same
// bits of range, incidence, normal and reflectivity. Embree may round another way for a ray within
// micrometres of an edge; one in 10,000 may be such a ray.
TEST_CASE("packets meet what single rays meet") {
  const int packet = GENERATE(4, 8, 16);
  const Vec3 at = GENERATE(Vec3{}, Vec3{500000.25, 4500000.75, -30.5});
  const World world = crowded_world(at);
  const Pose pose{at + Vec3{0.1, 0.2, 0.3}, from_roll_pitch_yaw(0.2, 0.1, -0.3)};
  // The short range leaves rays that meet nothing.
  const double range_max_m = GENERATE(100.0, 3.0);
  const Difference d =
      difference_to_single_rays(world, fan_of(90, 2, 70), pose, range_max_m, packet);
  CHECK(d.met > d.rays / 4);
  CHECK((d.met == d.rays) == (range_max_m == 100.0));
  CHECK(d.differing <= d.rays / 10000);
}

// Protects the ends of a fan: tiles that are not full, narrower or lower than a packet.
TEST_CASE("fans of any size are traced whole") {
  const World world = crowded_world({});
  const auto [beams, rays_azimuth, rays_elevation] = GENERATE(table<int, int, int>({{1, 1, 1},
                                                                                    {5, 1, 3},
                                                                                    {1, 1, 37},
                                                                                    {33, 1, 1},
                                                                                    {2, 1, 5},
                                                                                    {3, 7, 2},
                                                                                    {17, 1, 9},
                                                                                    {1, 3, 64}}));
  for (const int packet : {4, 8, 16}) {
    const Difference d = difference_to_single_rays(
        world, fan_of(beams, rays_azimuth, rays_elevation), {}, 100, packet);
    CHECK(d.rays == beams * rays_azimuth * rays_elevation);
    CHECK(d.met == d.rays);
    CHECK(d.differing == 0);
  }
}

// Protects worlds that Embree sees nothing of.
TEST_CASE("packets through planes alone, and through nothing") {
  const Fan fan = fan_of(9, 1, 11);
  const World planes =
      world_of({{PlaneShape{}, {{0, 0, -5}, {}}}, {PlaneShape{}, random_pose(3, {})}});
  const Difference d = difference_to_single_rays(planes, fan, {}, 40, 16);
  CHECK(d.met > 10);
  CHECK(d.differing == 0);
  for (const Hit& hit : Tracer(World{}).trace_fan(fan, {}, 100, Workers(1))) {
    REQUIRE(hit.instance == 0);
  }
}
