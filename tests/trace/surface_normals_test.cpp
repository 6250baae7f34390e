#include "trace/echo_points.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "core/units.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"

using namespace ensonify;

namespace {

const Pose kTurnedSonar{{1, -2, 0.5}, from_roll_pitch_yaw(0.1, 0.2, -0.3)};

Scatterer scatterer_at(Vec3 in_world, std::uint32_t instance) {
  Scatterer s;
  s.position_m = inverse_transform_point(kTurnedSonar, in_world);
  s.instance = instance;
  return s;
}

std::vector<Vec3> normals_of(const World& world, const std::vector<Scatterer>& scatterers) {
  ScattererList list;
  list.items = scatterers;
  std::vector<std::uint32_t> which(scatterers.size());
  for (std::uint32_t i = 0; i < which.size(); ++i) which[i] = i;
  std::vector<Vec3> normals(which.size());
  surface_normals(Tracer(world), kTurnedSonar, list, which, normals);
  return normals;
}

bool is_nowhere(Vec3 v) { return std::isnan(v.x) && std::isnan(v.y) && std::isnan(v.z); }

double distance_of(Vec3 a, Vec3 b) { return length(a - b); }

}  // namespace

// Protects frame and side: on a ball the normal is the radius, in the sonar's frame.
TEST_CASE("normals of a ball are its radii") {
  const Vec3 centre{6, -2, 0};
  const World world = world_of({{SphereShape{0.7}, {centre, {}}}});
  std::vector<Scatterer> scatterers;
  std::vector<Vec3> expected;
  for (int i = 0; i < 50; ++i) {
    const Vec3 radius = unit_vector(kPi + 0.8 * std::sin(i), 0.8 * std::cos(3 * i));
    scatterers.push_back(scatterer_at(centre + 0.7 * radius, 1));
    expected.push_back(rotate(conjugate(kTurnedSonar.rotation), radius));
  }
  const std::vector<Vec3> normals = normals_of(world, scatterers);
  for (std::size_t i = 0; i < normals.size(); ++i)
    CHECK(distance_of(normals[i], expected[i]) < 1e-5);
}

// Protects the side of a plane, which is seen from both, and places that a straight line from the
// sonar does not reach, as in water that bends rays: those of the floor behind a thin wall.
TEST_CASE("normals point to the sonar's side, also behind what hides them") {
  const World world = world_of({{PlaneShape{}, {{0, 0, -2}, {}}},
                                {BoxShape{{0.01, 5, 5}}, {{4, 0, 0}, {}}},
                                {PlaneShape{}, {{0, 0, 3}, {}}}});
  const auto normals =
      normals_of(world, {scatterer_at({3, -2, -2}, 1), scatterer_at({7, -1, -2}, 1),
                         scatterer_at({3, -2, 3}, 3), scatterer_at({3.99, -1, 0.1}, 2)});
  const auto in_sonar = [](Vec3 v) { return rotate(conjugate(kTurnedSonar.rotation), v); };
  CHECK(distance_of(normals[0], in_sonar({0, 0, 1})) < 1e-9);
  CHECK(distance_of(normals[1], in_sonar({0, 0, 1})) < 1e-9);
  CHECK(distance_of(normals[2], in_sonar({0, 0, -1})) < 1e-9);
  CHECK(distance_of(normals[3], in_sonar({-1, 0, 0})) < 1e-9);
}

// Protects what has no surface: a target in the water, and an instance that is elsewhere.
TEST_CASE("points off surfaces have no normal") {
  const World world = world_of({{PlaneShape{}, {{0, 0, -2}, {}}}});
  const auto normals = normals_of(world, {scatterer_at({4, -2, 0}, 2), scatterer_at({4, -2, -2}, 2),
                                          scatterer_at({4, -2, -1.5}, 1)});
  for (const Vec3 normal : normals) CHECK(is_nowhere(normal));
}
