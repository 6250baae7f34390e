#include "trace/packets.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/scatterers.h"
#include "core/units.h"

using namespace ensonify;

namespace {

World world_of(std::vector<std::pair<Shape, Pose>> things) {
  World world;
  for (auto& [shape, pose] : things) {
    const auto id = static_cast<std::uint32_t>(world.objects.size() + 1);
    world.objects.push_back({id, std::move(shape), pose, {}});
    world.instances.push_back({});
  }
  return world;
}

double draw(std::uint64_t i, unsigned k, double low, double high) {
  return low + (high - low) * uniform(77, 0, i, k);
}

Pose random_pose(std::uint64_t i, Vec3 at) {
  return {at + Vec3{draw(i, 0, 2, 14), draw(i, 1, -8, 8), draw(i, 2, -3, 3)},
          from_roll_pitch_yaw(draw(i, 3, -3, 3), draw(i, 4, -1, 1), draw(i, 5, -3, 3))};
}

// A rough square of 12 m with 2 x 24 x 24 triangles; smooth normals and reflectivity on request.
Shape rough_mesh(bool smooth) {
  constexpr int kCells = 24;
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < (kCells + 1) * (kCells + 1); ++i) {
    const double x = 0.5 * (i / (kCells + 1)) - 6, y = 0.5 * (i % (kCells + 1)) - 6;
    const double z = draw(i, 6, -0.2, 0.2);
    mesh->vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    if (!smooth) continue;
    // One in seven has none.
    mesh->normals.push_back({0, static_cast<float>(z), i % 7 == 0 ? 0.0f : 1.0f});
    mesh->reflectivity.push_back(static_cast<float>(draw(i, 7, 0, 1)));
  }
  for (std::uint32_t i = 0; i < kCells * kCells; ++i) {
    const std::uint32_t a = i / kCells * (kCells + 1) + i % kCells, b = a + kCells + 1;
    mesh->triangles.push_back({a, b, b + 1});
    mesh->triangles.push_back({a, b + 1, a + 1});
  }
  return MeshShape{mesh};
}

// Everything that can be met, at random poses about `at`; the sonar stands inside a room.
World crowded_world(Vec3 at) {
  std::vector<std::pair<Shape, Pose>> things{{BoxShape{{18, 16, 9}, true}, {at, {}}},
                                             {PlaneShape{}, {at + Vec3{0, 0, -5}, {}}},
                                             {PlaneShape{}, random_pose(99, at)},
                                             {rough_mesh(false), {at + Vec3{7, 0, -4}, {}}},
                                             {SphereShape{15, true}, {at + Vec3{3, 0, 0}, {}}}};
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto pose = [&](std::uint64_t k) { return random_pose(10 * i + k, at); };
    things.push_back({rough_mesh(i % 2 == 0), pose(0)});
    things.push_back({BoxShape{{0.3, 0.6, 0.9}, false}, pose(1)});
    things.push_back({CylinderShape{0.4, 0.8}, pose(2)});
    things.push_back({SphereShape{0.7, false}, pose(3)});
  }
  return world_of(std::move(things));
}

Fan fan_of(int beams, int rays_azimuth, int rays_elevation) {
  Sonar sonar;
  sonar.beam_count = beams;
  sonar.beam_spacing_rad = radians(120) / beams;
  sonar.elevation_fan_rad = radians(40);
  sonar.rays_azimuth = rays_azimuth;
  sonar.rays_elevation = rays_elevation;
  return make_fan(sonar);
}

bool same_hit(const Hit& a, const Hit& b) {
  return a.range_m == b.range_m && a.cos_incidence == b.cos_incidence && a.instance == b.instance &&
         a.reflectivity == b.reflectivity && a.normal == b.normal;
}

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
