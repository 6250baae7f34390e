#include "trace/packets.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

namespace {

void sort_by_range(std::vector<Hit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.range_m != b.range_m ? a.range_m < b.range_m : a.instance < b.instance;
  });
}

bool same_hits(std::span<const Hit> a, std::span<const Hit> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_hit);
}

// The same surface at the same bits of range; what Embree interpolates in float within rounding.
bool alike(const Hit& a, const Hit& b) {
  return a.range_m == b.range_m && a.instance == b.instance &&
         std::abs(a.cos_incidence - b.cos_incidence) < 1e-5 &&
         std::abs(a.reflectivity - b.reflectivity) < 1e-5 && length(a.normal - b.normal) < 1e-5;
}

Ray random_ray(std::uint64_t i, Vec3 at) {
  const Vec3 direction = unit_vector(draw(i, 8, -1, 1), draw(i, 9, -0.6, 0.6));
  return {at + Vec3{draw(i, 10, -1, 1), draw(i, 11, -1, 1), draw(i, 12, -1, 1)}, direction};
}

// Closed forms by their own formulas, one after the other, without Embree.
std::vector<Hit> brute_force(const World& world, const Ray& ray, double range_max_m) {
  std::vector<Hit> hits;
  for (const WorldObject& object : world.objects) {
    const Ray local{inverse_transform_point(object.pose, ray.origin_m),
                    rotate(conjugate(object.pose.rotation), ray.direction)};
    const auto hit = std::visit(
        [&](const auto& shape) -> std::optional<SurfaceHit> {
          if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, MeshShape>) {
            return std::nullopt;
          } else {
            return intersect(shape, local, 1e-6);
          }
        },
        object.shape);
    if (!hit || hit->range_m > range_max_m) continue;
    hits.push_back({hit->range_m, 0, object.instance, 1, {}});
  }
  sort_by_range(hits);
  return hits;
}

// What is called next finds NaNs where it sets nothing.
[[gnu::noinline]] void spoil_stack() {
  volatile float unset[16384];
  for (volatile float& value : unset) value = std::numeric_limits<float>::quiet_NaN();
}

World closed_forms(Vec3 at) {
  World world = crowded_world(at);
  std::erase_if(world.objects, [](const WorldObject& object) {
    return std::holds_alternative<MeshShape>(object.shape);
  });
  return world;
}

}  // namespace

// Protects what shadows and amodal masks stand on: every closed form along a ray, in order and at
// its range, against all of them tried one by one.
TEST_CASE("all closed forms along a ray, in order") {
  const Vec3 at = GENERATE(Vec3{}, Vec3{500000.25, 4500000.75, -30.5});
  const double range_max_m = GENERATE(100.0, 7.0);
  const World world = closed_forms(at);
  const Tracer tracer(world);
  std::size_t several = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const Ray ray = random_ray(i, at);
    const std::vector<Hit> expected = brute_force(world, ray, range_max_m);
    const std::vector<Hit> hits = tracer.hits_along(ray, range_max_m);
    REQUIRE(expected.size() <= kMostLayers);
    REQUIRE(hits.size() == expected.size());
    several += hits.size() > 2;
    for (std::size_t k = 0; k < hits.size(); ++k) {
      REQUIRE(hits[k].instance == expected[k].instance);
      REQUIRE(hits[k].range_m == Approx(expected[k].range_m).epsilon(1e-12));
    }
  }
  CHECK(several > (range_max_m > 10 ? 1000 : 1));
}

// Protects "were all before it transparent": along a ray an object is met where it would be met
// alone in the world, whatever stands before it; meshes and closed forms, to the bits of the range.
// A ray within micrometres of a triangle's edge may take the other triangle, one in 1,000 hits.
TEST_CASE("behind others an object is met as if it were alone") {
  const Vec3 at = GENERATE(Vec3{}, Vec3{500000.25, 4500000.75, -30.5});
  const World world = crowded_world(at);
  const Tracer tracer(world);
  std::vector<World> alone(world.objects.size());
  std::vector<Tracer> tracers;
  for (std::size_t k = 0; k < alone.size(); ++k) {
    alone[k].objects = {world.objects[k]};
    tracers.emplace_back(alone[k]);
  }
  std::size_t met = 0, differing = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Ray ray = random_ray(i, at);
    std::vector<Hit> expected;
    for (const Tracer& one : tracers) {
      const Hit hit = one.first_hit(ray, 60);
      if (hit.instance != 0) expected.push_back(hit);
    }
    sort_by_range(expected);
    if (expected.size() > kMostLayers) expected.resize(kMostLayers);
    met += expected.size();
    const std::vector<Hit> hits = tracer.hits_along(ray, 60);
    differing += !std::equal(hits.begin(), hits.end(), expected.begin(), expected.end(), alike);
    differing += !alike(tracer.first_hit(ray, 60), hits.at(0));
  }
  CHECK(met > 8000);
  CHECK(differing <= met / 1000);
}

// Protects the program from Embree, which with its assertions on, as in Debian, ends it where a
// lane without a ray holds what is no ray.
TEST_CASE("lanes without a ray are sound as well") {
  const World world = world_of({{rough_mesh(false), {{0, 0, -3}, {}}}});
  const Tracer tracer(world);
  for (int i = 0; i < 20; ++i) {
    spoil_stack();
    CHECK(tracer.hits_along({{}, unit_vector(0.1 * i, -0.8)}, 50).size() == 1);
  }
}

// Protects the fan's rays against the company that they are continued in, packets of any breadth,
// and against the number of threads; and the rule which instance is left out.
TEST_CASE("a fan is continued as its rays are one by one") {
  const auto [beams, rays_azimuth, rays_elevation] =
      GENERATE(table<int, int, int>({{40, 2, 35}, {1, 1, 1}, {5, 1, 3}, {1, 1, 37}, {33, 1, 1}}));
  const Vec3 at{20, -30, 5};
  const World world = crowded_world(at);
  const Fan fan = fan_of(beams, rays_azimuth, rays_elevation);
  const Pose pose{at + Vec3{0.1, 0.2, 0.3}, from_roll_pitch_yaw(0.2, 0.1, -0.3)};
  const double range_max_m = GENERATE(100.0, 5.0);
  const Tracer tracer(world);
  const std::vector<Hit> first = tracer.trace_fan(fan, pose, range_max_m, Workers(1));
  Scene scene;
  build_scene(world, own_poses(world), build_hierarchies(world), scene);
  AlongScene along;
  build_along_scene(scene, along);
  std::size_t differing = 0;
  for (const int packet : {4, 8, 16}) {
    along.rays = packet;
    const HitsBehind behind = trace_behind(along, fan, first, pose, range_max_m, Workers(2));
    REQUIRE(behind.offset.size() == fan.size() + 1);
    REQUIRE(behind.offset.back() == behind.hits.size());
    std::size_t i = 0;
    for (const double azimuth : fan.azimuth_rad) {
      for (const double elevation : fan.elevation_rad) {
        const Vec3 direction = normalized(rotate(pose.rotation, unit_vector(azimuth, elevation)));
        std::vector<Hit> all;
        if (first[i].instance != 0) {
          all = tracer.hits_along({pose.position_m, direction}, range_max_m);
        }
        std::erase_if(all, [&](const Hit& hit) { return hit.instance == first[i].instance; });
        all.resize(std::min<std::size_t>(all.size(), kMostLayers - 1));
        differing += !same_hits(behind.of_ray(i), all);
        ++i;
      }
    }
  }
  CHECK(differing <= fan.size() / 1000);
  const HitsBehind one = tracer.trace_behind(fan, first, pose, range_max_m, Workers(1));
  const HitsBehind three = tracer.trace_behind(fan, first, pose, range_max_m, Workers(3));
  CHECK(one.offset == three.offset);
  CHECK(same_hits(one.hits, three.hits));
  // What was met first is still what it was.
  CHECK(same_hits(tracer.trace_fan(fan, pose, range_max_m, Workers(2)), first));
}

// Protects the limit of layers: of twelve walls one behind the other the nearest eight are told,
// whatever order they were made in.
TEST_CASE("the nearest walls are told where there are too many") {
  std::vector<std::pair<Shape, Pose>> walls;
  for (int k = 0; k < 12; ++k) {
    const double x = 2 + (k * 5) % 12;
    walls.push_back({BoxShape{{0.1, 5, 5}, false}, {{x, 0, 0}, {}}});
  }
  const World world = world_of(std::move(walls));
  const Tracer tracer(world);
  const std::vector<Hit> hits = tracer.hits_along({{}, {1, 0, 0}}, 100);
  REQUIRE(hits.size() == kMostLayers);
  for (int k = 0; k < kMostLayers; ++k) CHECK(hits[k].range_m == Approx(1.9 + k).epsilon(1e-12));
}

// Protects worlds that Embree sees nothing of, and rays that met nothing: they are not continued.
TEST_CASE("rays are continued through planes alone, and through nothing") {
  const Fan fan = fan_of(9, 1, 11);
  const World planes =
      world_of({{PlaneShape{}, {{0, 0, -5}, {}}}, {PlaneShape{}, {{0, 0, -7}, {}}}});
  const Tracer tracer(planes);
  const std::vector<Hit> first = tracer.trace_fan(fan, {}, 40, Workers(1));
  const HitsBehind behind = tracer.trace_behind(fan, first, {}, 40, Workers(1));
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double below = first[i].range_m * 7 / 5;
    const bool reaches = first[i].instance == 1 && below <= 40;
    REQUIRE(behind.of_ray(i).size() == std::size_t{reaches});
    if (reaches) CHECK(behind.of_ray(i)[0].range_m == Approx(below).epsilon(1e-12));
  }
  const std::vector<Hit> none(fan.size());
  CHECK(tracer.trace_behind(fan, none, {}, 40, Workers(1)).hits.empty());
  const World empty;
  CHECK(Tracer(empty).trace_behind(fan, none, {}, 40, Workers(1)).hits.empty());
}
