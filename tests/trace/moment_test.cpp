// One world, many placements and many moments.
#include <algorithm>
#include <cmath>
#include <complex>

#include "acoustics/pattern.h"
#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"
#include "trace/scene.h"

using namespace ensonify;

namespace {

// A square of 1 m with a rough surface and colours.
std::shared_ptr<const Mesh> rough_mesh() {
  constexpr std::uint32_t kSide = 13;
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const auto draw = [&](unsigned k) { return static_cast<float>(uniform(91, 0, i, k)); };
    mesh->vertices.push_back({static_cast<float>(i / kSide) / 12 - 0.5f,
                              static_cast<float>(i % kSide) / 12 - 0.5f, 0.1f * draw(0)});
    mesh->reflectivity.push_back(draw(1));
    if (i / kSide == kSide - 1 || i % kSide == kSide - 1) continue;
    mesh->triangles.push_back({i, i + kSide, i + kSide + 1});
    mesh->triangles.push_back({i, i + kSide + 1, i + 1});
  }
  return mesh;
}

Pose random_pose(std::uint64_t i) {
  const auto draw = [&](unsigned k, double low, double high) {
    return low + (high - low) * uniform(17, 0, i, k);
  };
  return {{draw(0, 3, 15), draw(1, -8, 8), draw(2, -4, 4)},
          from_roll_pitch_yaw(draw(3, -3, 3), draw(4, -1, 1), draw(5, -3, 3))};
}

std::vector<Pose> random_poses(std::size_t count, std::uint64_t seed) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) poses.push_back(random_pose(1000 * seed + i));
  return poses;
}

Sonar fan_of(int beams, int rays, double fov_rad, double fan_rad) {
  return test::fan_sonar(beams, fov_rad, 20, rays, fan_rad);
}

std::vector<Hit> hits_of(const Tracer& tracer, int threads = 1) {
  static const Fan fan = make_fan(fan_of(120, 60, radians(120), radians(50)));
  return tracer.trace_fan(fan, {}, 20, Workers(threads));
}

bool same(const Hit& a, const Hit& b) {
  return a.range_m == b.range_m && a.cos_incidence == b.cos_incidence && a.instance == b.instance &&
         a.reflectivity == b.reflectivity && a.normal == b.normal;
}

bool all_same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return std::ranges::equal(a, b, same);
}

std::size_t met(const std::vector<Hit>& hits) {
  return std::ranges::count_if(hits, [](const Hit& hit) { return hit.instance != 0; });
}

// Everything that can move.
World crowd() {
  std::vector<std::pair<Shape, Pose>> things{{PlaneShape{}, {}}};
  const std::shared_ptr<const Mesh> mesh = rough_mesh();
  for (int i = 0; i < 20; ++i) {
    things.push_back({MeshShape{mesh}, {}});
    things.push_back({SphereShape{0.5, false}, {}});
    things.push_back({BoxShape{{0.3, 0.6, 0.9}, false}, {}});
    things.push_back({CylinderShape{0.4, 0.8}, {}});
  }
  return world_of(std::move(things));
}

}  // namespace

// Protects instancing: one hierarchy a mesh, and the hits, to the bit, of a mesh for each
// placement.
TEST_CASE("placements of one mesh are hit like copies of it") {
  const std::shared_ptr<const Mesh> mesh = rough_mesh();
  std::vector<std::pair<Shape, Pose>> shared, copied;
  for (const Pose& pose : random_poses(60, 1)) {
    shared.push_back({MeshShape{mesh}, pose});
    copied.push_back({MeshShape{std::make_shared<const Mesh>(*mesh)}, pose});
  }
  const World placements = world_of(std::move(shared)), copies = world_of(std::move(copied));
  CHECK(build_hierarchies(placements)->scenes.size() == 1);
  CHECK(build_hierarchies(copies)->scenes.size() == 60);
  const std::vector<Hit> hits = hits_of(Tracer(placements));
  CHECK(met(hits) > 500);
  CHECK(all_same(hits, hits_of(Tracer(copies))));
}

// Protects moving objects: every kind of shape is where it is at the moment, not where it was.
TEST_CASE("what moves is met where it is") {
  const World world = world_of({{mesh_box(1, 1, 1), {{0, 0, 0}, {}}},
                                {SphereShape{0.5, false}, {{0, 0, 0}, {}}},
                                {PlaneShape{}, {{0, 0, -50}, {}}},
                                {BoxShape{{1, 1, 1}, false}, {{0, -90, 0}, {}}}});
  const Tracer tracer(world);
  for (int ping = 0; ping < 5; ++ping) {
    const double way = 0.37 * ping;
    const Tracer moment =
        tracer.at(std::vector<Pose>{{{5 + way, 0, 0}, {}},
                                    {{0, 4 + way, 0.3}, {}},
                                    {{0, 0, -3 - way}, {}},
                                    {{-6 - way, 0, 0}, from_roll_pitch_yaw(0, 0, kPi / 4)}});
    const auto hit = [&](Vec3 d) { return moment.first_hit({{0, 0, 0}, d}, 100); };
    CHECK(hit({1, 0, 0}).instance == 1);
    CHECK(hit({1, 0, 0}).range_m == Approx(4 + way).epsilon(1e-12));
    CHECK(hit({0, 1, 0}).instance == 2);
    CHECK(hit({0, 1, 0}).range_m == Approx(4 + way - 0.4).epsilon(1e-12));
    CHECK(std::abs(hit({0, 1, 0}).normal.z) == Approx(0.6).epsilon(1e-12));
    CHECK(hit({0, 0, -1}).instance == 3);
    CHECK(hit({0, 0, -1}).range_m == Approx(3 + way).epsilon(1e-12));
    CHECK(hit({-1, 0, 0}).instance == 4);
    CHECK(hit({-1, 0, 0}).range_m == Approx(6 + way - std::sqrt(2)).epsilon(1e-12));
  }
}

// Protects data sets against how a moment came about: a world that stands so from the start gives
// the same bits, whatever was asked before.
TEST_CASE("a moment is the world that stands so") {
  World world = crowd();
  const Tracer tracer(world);
  for (std::uint64_t k = 0; k < 3; ++k) {
    const std::vector<Pose> poses = random_poses(world.objects.size(), k);
    const std::vector<Hit> hits =
        hits_of(tracer.at(random_poses(world.objects.size(), k + 9)).at(poses));
    World standing = world;
    for (std::size_t i = 0; i < poses.size(); ++i) standing.objects[i].pose = poses[i];
    CHECK(met(hits) > 1000);
    CHECK(all_same(hits, hits_of(Tracer(standing))));
  }
}

// Protects pings side by side: moments are built and traced at once without disturbing each other,
// and outlive the tracer that they come from.
TEST_CASE("moments on several threads do not disturb each other") {
  constexpr std::size_t kMoments = 12;
  const World world = crowd();
  const auto poses = [&](std::size_t i) { return random_poses(world.objects.size(), i); };
  auto tracer = std::make_unique<Tracer>(world);
  std::vector<std::vector<Hit>> alone, together(kMoments);
  for (std::size_t i = 0; i < kMoments; ++i) alone.push_back(hits_of(tracer->at(poses(i))));
  Workers(4).for_each(kMoments,
                      [&](std::size_t i) { together[i] = hits_of(tracer->at(poses(i)), 2); });
  for (std::size_t i = 0; i < kMoments; ++i) CHECK(all_same(alone[i], together[i]));
  CHECK_FALSE(all_same(alone[0], alone[1]));
  const Tracer last = tracer->at(poses(5));
  tracer.reset();
  CHECK(all_same(hits_of(last), alone[5]));
}

// Protects coherent echoes of what moves: the rays that follow the first ones see the same moment.
// A sphere's target strength is 20 log10(a/2) wherever it is.
TEST_CASE("a mirror keeps its level where it moves", "[figure]") {
  constexpr double kRadius_m = 0.5, kSoundSpeed = 1500;
  const Sonar sonar = fan_of(256, 114, radians(45), radians(20));
  World world = world_of({{SphereShape{kRadius_m, false}, {{0, -40, 0}, {}}}});
  world.objects[0].material.coherent = CoherentModel::kirchhoff;
  world.objects[0].material.reflection = 1;
  const Water water{kSoundSpeed, 0};
  const SurfaceScattering scattering = make_surface_scattering(sonar, water, world);
  const Fan fan = make_fan(sonar);
  const Tracer tracer(world);
  for (const double range_m : {3.0, 4.7}) {
    const Tracer moment = tracer.at(std::vector<Pose>{{{range_m + kRadius_m, 0, 0}, {}}});
    const auto hits = moment.trace_fan(fan, {}, sonar.range_max_m, Workers(2));
    std::complex<double> sum = 0;
    for (const Scatterer& s : kirchhoff_scatterers(fan, hits, moment, {}, scattering, Workers(2))) {
      const double pattern = line_pattern(s.arrival.elevation_rad, sonar.elevation_width_rad);
      sum +=
          std::complex<double>(s.mean) * (s.gain / pattern) *
          std::polar(1.0, -2 * kPi * sonar.frequency_hz * (s.delay_s - 2 * range_m / kSoundSpeed));
    }
    // A wave from a point: the sphere spreads it by a/(a + r) more.
    const double expected = kRadius_m / 2 * range_m * range_m / (range_m * (range_m + kRadius_m));
    CHECK(20 * std::log10(std::abs(sum) * range_m * range_m / expected) == Approx(0).margin(0.3));
  }
}

// Protects scenes of many small things: each is found, and only once.
TEST_CASE("five thousand spheres are each met where they are") {
  World world;
  constexpr int kSide = 71;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 at{20, 0.5 * (i / kSide - kSide / 2), 0.5 * (i % kSide - kSide / 2)};
    add_object(world, SphereShape{0.2, false}, {at, {}});
  }
  const Tracer tracer(world);
  for (const WorldObject& object : world.objects) {
    const double distance = length(object.pose.position_m);
    const Hit hit = tracer.first_hit({{0, 0, 0}, normalized(object.pose.position_m)}, 100);
    // Towards the edges the spheres hide each other.
    if (std::abs(object.pose.position_m.y) + std::abs(object.pose.position_m.z) > 10) continue;
    REQUIRE(hit.instance == object.instance);
    REQUIRE(hit.range_m == Approx(distance - 0.2).epsilon(1e-12));
  }
}
