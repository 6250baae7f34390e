#include "trace/tracer.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/scatterers.h"
#include "core/units.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

Vec3 random_direction(std::uint64_t i) {
  return unit_vector(2 * kPi * uniform(6, 0, i, 0), std::asin(2 * uniform(6, 0, i, 1) - 1));
}

}  // namespace

// Protects range and phase: the mesh's hit is the triangle's in double (a float range of 60 m is
// good to 4 um, a hundredth of a radian), through any pose.
TEST_CASE("a box of triangles is hit like the closed form") {
  const Pose pose{{3, -2, 1}, from_roll_pitch_yaw(0.3, -0.7, 1.1)};
  const World closed = world_of({{BoxShape{{1, 2, 0.5}, false}, pose}});
  const World meshed = world_of({{mesh_box(1, 2, 0.5), pose}});
  const Tracer a(closed), b(meshed);
  int hits = 0;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Vec3 from = pose.position_m + 30.0 * random_direction(i);
    const Vec3 to = pose.position_m + 0.6 * random_direction(i + 5000);
    const Ray ray{from, normalized(to - from)};
    const Hit x = a.first_hit(ray, 100), y = b.first_hit(ray, 100);
    REQUIRE(x.instance == y.instance);
    if (x.instance == 0) continue;
    ++hits;
    // Within a few um of an edge the two may choose different faces.
    if (std::abs(x.cos_incidence - y.cos_incidence) > 1e-5) continue;
    CHECK(x.range_m == Approx(y.range_m).margin(1e-9));
  }
  CHECK(hits > 2000);
}

TEST_CASE("the nearest of several shapes is found") {
  const World world = world_of({{SphereShape{20, true}, {}},
                                {CylinderShape{0.2, 1}, {{4, 0, 0}, {}}},
                                {PlaneShape{}, {{0, 0, -3}, {}}},
                                {mesh_box(0.5, 0.5, 0.5), {{0, 6, 0}, {}}}});
  const Tracer tracer(world);
  const auto shoot = [&](Vec3 d) { return tracer.first_hit({{0, 0, 0}, normalized(d)}, 100); };
  CHECK(shoot({1, 0, 0}).instance == 2);
  CHECK(shoot({1, 0, 0}).range_m == Approx(3.8).margin(1e-12));
  CHECK(shoot({1, 0, 0}).cos_incidence == Approx(1));
  CHECK(shoot({-1, 0, 0}).instance == 1);
  CHECK(shoot({-1, 0, 0}).range_m == Approx(20));
  CHECK(shoot({0, 0, -1}).instance == 3);
  CHECK(shoot({0, 0, -1}).range_m == Approx(3));
  CHECK(shoot({0, 1, 0}).instance == 4);
  CHECK(shoot({0, 1, 0}).range_m == Approx(5.5));
  // Beyond the range there is nothing.
  CHECK(tracer.first_hit({{0, 0, 0}, {1, 0, 0}}, 3.7).instance == 0);
  CHECK(tracer.first_hit({{0, 0, 0}, {-1, 0, 0}}, 19.9).instance == 0);
}

TEST_CASE("an empty world is silent") {
  const World world;
  CHECK(Tracer(world).first_hit({{0, 0, 0}, {1, 0, 0}}, 1e4).instance == 0);
}

// Protects fixed scatterers and mirrors: the normal stands in the world, whatever the pose, and is
// what the incidence was taken from.
TEST_CASE("a hit carries the surface's normal in the world") {
  const Pose turned{{4, 0.3, -0.2}, from_roll_pitch_yaw(0.4, -0.6, 0.9)};
  const auto check = [](const World& world, Ray ray, Vec3 expected) {
    const Hit hit = Tracer(world).first_hit(ray, 100);
    REQUIRE(hit.instance == 1);
    CHECK(length(hit.normal) == Approx(1).epsilon(1e-12));
    CHECK(std::abs(dot(hit.normal, expected)) == Approx(1).epsilon(1e-9));
    CHECK(std::abs(dot(hit.normal, ray.direction)) == Approx(hit.cos_incidence).epsilon(1e-6));
    CHECK(hit.reflectivity == 1);
  };
  const Ray aim{{0, 0, 0}, normalized(turned.position_m)};
  const auto face = [&](double a, double b, double c) {
    // The face of a box through which the ray towards its middle goes in.
    const Vec3 d = rotate(conjugate(turned.rotation), aim.direction);
    const double x = std::abs(d.x) / a, y = std::abs(d.y) / b, z = std::abs(d.z) / c;
    if (x > y && x > z) return rotate(turned.rotation, {1, 0, 0});
    return y > z ? rotate(turned.rotation, {0, 1, 0}) : rotate(turned.rotation, {0, 0, 1});
  };
  check(world_of({{BoxShape{{1, 2, 0.5}, false}, turned}}), aim, face(1, 2, 0.5));
  check(world_of({{mesh_box(1, 2, 0.5), turned}}), aim, face(1, 2, 0.5));
  check(world_of({{PlaneShape{}, turned}}), aim, rotate(turned.rotation, {0, 0, 1}));
  const World ball = world_of({{SphereShape{0.5, false}, turned}});
  const Ray beside{{0, 0, 0}, normalized(turned.position_m + Vec3{0, 0.2, 0.1})};
  const double range = Tracer(ball).first_hit(beside, 100).range_m;
  check(ball, beside, normalized(range * beside.direction - turned.position_m));
}

// Protects coloured meshes: linear over a face, of the right face, and 1 where there are none.
TEST_CASE("the reflectivity of a mesh is interpolated") {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{5, -2, -2}, {5, 2, -2}, {5, 2, 2}, {5, -2, 2}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh->reflectivity = {0, 0.5f, 1, 0.5f};  // (y + z + 4) / 8
  const World world = world_of({{MeshShape{mesh}, {}}});
  const Tracer tracer(world);
  for (const auto& [y, z] : {std::pair{1.0, -1.5}, {-1.0, 0.5}, {0.3, 0.2}, {1.9, 1.95}}) {
    const Hit hit = tracer.first_hit({{0, 0, 0}, normalized(Vec3{5, y, z})}, 100);
    REQUIRE(hit.instance == 1);
    CHECK(hit.reflectivity == Approx((y + z + 4) / 8).margin(1e-5));
  }
}

// Protects promises about threads: the same hits from one thread and from four.
TEST_CASE("tracing a fan does not depend on threads") {
  const World world = world_of({{mesh_box(1, 2, 0.5), {{4, 0, 0}, from_roll_pitch_yaw(1, 1, 1)}},
                                {SphereShape{9, true}, {}}});
  const Tracer tracer(world);
  Sonar sonar;
  sonar.beam_count = 64;
  sonar.beam_spacing_rad = radians(1);
  sonar.elevation_fan_rad = radians(20);
  sonar.rays_elevation = 16;
  const Fan fan = make_fan(sonar);
  const Pose pose{{0, 0, 0}, from_roll_pitch_yaw(0, 0.1, 0.2)};
  const auto one = tracer.trace_fan(fan, pose, 20, Workers(1));
  const auto four = tracer.trace_fan(fan, pose, 20, Workers(4));
  for (std::size_t i = 0; i < one.size(); ++i) {
    REQUIRE(one[i].range_m == four[i].range_m);
    REQUIRE(one[i].instance == four[i].instance);
  }
}

// Protects worlds in map coordinates: at a northing of 4.5e6 m a float's steps are half a metre.
TEST_CASE("hits do not depend on where the world's origin lies") {
  const Vec3 far{500000.25, 4500000.75, -30.5};
  const auto things = [](Vec3 at) {
    return world_of(
        {{mesh_box(0.5f, 1, 0.25f), {at + Vec3{4, 0.5, 0}, from_roll_pitch_yaw(1, 2, 3)}},
         {SphereShape{0.7, false}, {at + Vec3{5, -2, 0}, {}}},
         {CylinderShape{0.4, 1}, {at + Vec3{5, 3, 0}, {}}},
         {SphereShape{9, true}, {at, {}}}});
  };
  const World near_world = things({}), far_world = things(far);
  const Tracer near_tracer(near_world), far_tracer(far_world);
  int agreeing = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Vec3 direction = random_direction(i);
    const Hit a = near_tracer.first_hit({{0, 0, 0}, direction}, 20);
    const Hit b = far_tracer.first_hit({far, direction}, 20);
    // Rays within micrometres of an edge may fall on either side of it.
    if (a.instance != b.instance || std::abs(a.cos_incidence - b.cos_incidence) > 1e-4) continue;
    ++agreeing;
    REQUIRE(a.range_m == Approx(b.range_m).margin(1e-6));
  }
  CHECK(agreeing > 1990);
}

// Protects levels of smooth meshes: normals that are missing or cancel are not taken for facing
// ones.
TEST_CASE("a smooth normal of no length gives way to the face's") {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{3, -9, -9}, {6, 9, -9}, {4, 0, 9}};
  mesh->triangles = {{0, 1, 2}};
  const World flat = world_of({{MeshShape{mesh}, {}}});
  auto smooth = std::make_shared<Mesh>(*mesh);
  smooth->normals.assign(3, {0, 0, 0});
  const World degenerate = world_of({{MeshShape{smooth}, {}}});
  const Ray ray{{0, 0, 0}, {1, 0, 0}};
  const Hit expected = Tracer(flat).first_hit(ray, 20);
  REQUIRE(expected.instance == 1);
  CHECK(expected.cos_incidence < 0.99);
  CHECK(Tracer(degenerate).first_hit(ray, 20).cos_incidence == expected.cos_incidence);
}

// Protects levels against ray counts: cells tile each sector without gap or overlap, with the
// exact solid angle of the fan.
TEST_CASE("the fan tiles its sectors") {
  Sonar sonar;
  sonar.beam_count = 10;
  sonar.beam_spacing_rad = radians(2);
  sonar.elevation_fan_rad = radians(20);
  sonar.rays_azimuth = GENERATE(1, 3, 4);
  sonar.rays_elevation = GENERATE(1, 7);
  const Fan fan = make_fan(sonar);
  double sum = 0;
  for (const double angle : fan.solid_angle_sr) sum += angle * fan.azimuth_rad.size();
  CHECK(sum == Approx(radians(20) * 2 * std::sin(radians(10))).epsilon(1e-12));
  for (int j = 0; j < 10; ++j) {
    for (int a = 0; a < sonar.rays_azimuth; ++a) {
      CHECK(sector_of(sonar, fan.azimuth_rad[j * sonar.rays_azimuth + a]) == j);
    }
  }
  CHECK(fan.elevation_rad.front() ==
        Approx(radians(-10 + 10.0 / sonar.rays_elevation)).margin(1e-15));
  CHECK(ray_index(fan, 9, sonar.rays_azimuth - 1, sonar.rays_elevation - 1) == fan.size() - 1);
}
