#include "world/scene_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "catch.h"

using namespace ensonify;

namespace {

// By the divergence theorem; positive if triangles are counterclockwise as seen from outside.
double volume_m3(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = to_vec3(mesh.vertices[t[0]]);
    sum += dot(a, cross(to_vec3(mesh.vertices[t[1]]), to_vec3(mesh.vertices[t[2]]))) / 6;
  }
  return sum;
}

// Every edge belongs to two triangles that run along it in opposite directions.
bool is_closed(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto [from, to] = edge.first;
    return edge.second == 1 && edges.contains({to, from});
  });
}

// The signed distances of points all over the triangles: their least and largest.
template <class Shape>
std::pair<double, double> distances_m(const Shape& shape, const Mesh& mesh) {
  constexpr int kSteps = 6;
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = to_vec3(mesh.vertices[t[0]]), b = to_vec3(mesh.vertices[t[1]]),
               c = to_vec3(mesh.vertices[t[2]]);
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double u = double(i) / kSteps, v = double(j) / kSteps;
        const double d = signed_distance_m(shape, a + u * (b - a) + v * (c - a));
        least = std::min(least, d);
        most = std::max(most, d);
      }
    }
  }
  return {least, most};
}

World world_of(const std::vector<Shape>& shapes) {
  World world;
  for (const Shape& shape : shapes) {
    const auto id = static_cast<std::uint16_t>(world.objects.size() + 1);
    world.objects.push_back({.instance = id, .shape = shape, .pose = {}, .material = {}});
    Instance instance;
    instance.id = id;
    instance.name = "object " + std::to_string(id);
    instance.class_id = 1;
    world.instances.push_back(instance);
  }
  return world;
}

std::string glb_of(const World& world, const std::vector<SceneObject>& objects) {
  std::string bytes;
  write_scene_glb(world, objects, [&](std::string_view more) { bytes += more; });
  return bytes;
}

}  // namespace

// Protects comparisons with reconstructed surfaces: the stated distance holds all over, and the
// sides are right.
TEST_CASE("closed forms are tessellated to the stated distance") {
  constexpr double kFloat = 1e-6;  // rounding of vertices of about a meter
  const double r = 0.7, h = 1.1;
  const SphereShape sphere{r};
  const CylinderShape cylinder{r, h};
  const BoxShape box{{0.5, 1, 2}};
  const Mesh ball = tessellated(sphere), rod = tessellated(cylinder), block = tessellated(box);
  CHECK(is_closed(ball));
  CHECK(is_closed(rod));
  CHECK(is_closed(block));
  for (const auto& [least, most] : {distances_m(sphere, ball), distances_m(cylinder, rod)}) {
    CHECK(least >= -kChordOfRadius * r - kFloat);
    CHECK(least < -0.2 * kChordOfRadius * r);  // no finer than it has to be
    CHECK(most < kFloat);
  }
  const auto [least, most] = distances_m(box, block);
  CHECK((least > -kFloat && most < kFloat));
  // An inscribed polygon of 100 corners has 1 - (2 pi / 100)^2 / 6 of the circle's area, and the
  // sphere loses as much again along its meridians.
  constexpr double kLost = 4 * std::numbers::pi * std::numbers::pi / 6e4;
  const double sphere_m3 = 4 * std::numbers::pi / 3 * r * r * r;
  CHECK(volume_m3(ball) == Approx(sphere_m3).epsilon(2.5 * kLost));
  CHECK(volume_m3(rod) == Approx(2 * h * std::numbers::pi * r * r * (1 - kLost)).epsilon(1e-5));
  CHECK(volume_m3(block) == Approx(8.0));
}

TEST_CASE("rooms are seen from inside") {
  CHECK(volume_m3(tessellated(BoxShape{{1, 1, 1}, true})) == Approx(-8.0));
  CHECK(volume_m3(tessellated(SphereShape{1, true})) < -4);
}

// Protects the extent of infinite planes in the files: a closed form of the spheres that they cut.
TEST_CASE("a plane is cut to the reach of the sonar") {
  const Pose pose{{1, 2, -3}, {}};
  const auto plane = tessellated(PlaneShape{}, pose, {{{1, 2, 0}, {5, 2, 1}, {99, 0, 50}}, 5});
  REQUIRE(plane.has_value());
  Bounds bounds;
  for (const auto& v : plane->vertices) bounds.add(to_vec3(v));
  // Of circles with the radii 4 and 3, around (0, 0) and (4, 0) of the plane.
  CHECK(bounds.low.x == Approx(-4.0));
  CHECK(bounds.high.x == Approx(7.0));
  CHECK(bounds.low.y == Approx(-4.0));
  CHECK(bounds.high.y == Approx(4.0));
  CHECK((bounds.low.z == 0 && bounds.high.z == 0));
  CHECK_FALSE(tessellated(PlaneShape{}, pose, {{{1, 2, 3}}, 5}));
}

TEST_CASE("objects of equal shape share a mesh, and planes out of reach are left out") {
  const World world = world_of({SphereShape{1}, PlaneShape{}, SphereShape{1}, SphereShape{2}});
  const std::vector<Pose> poses = {{}, {{0, 0, -50}, {}}, {{4, 0, 0}, {}}, {}};
  const auto objects = scene_objects(world, poses, {{{0, 0, 0}}, 10});
  REQUIRE(objects.size() == 3);
  CHECK(objects[0].mesh == objects[1].mesh);
  CHECK(objects[0].mesh != objects[2].mesh);
  CHECK(objects[1].pose == poses[2]);
  const SceneSize size = scene_size(world);
  CHECK(size.vertices == 3 * objects[0].mesh->vertices.size() + 4);
  // The size bounds the file, in which the mesh of equal spheres stands once.
  const std::string glb = glb_of(world, objects);
  CHECK(glb.size() < size.glb_bytes);
  CHECK(glb.size() > 2 * size.glb_bytes / 3 - 100);
}

// Protects readers of glTF, in which empty lists are not valid.
TEST_CASE("a world without surfaces is a file without meshes") {
  const World world = world_of({});
  const std::string glb = glb_of(world, {});
  CHECK(glb.starts_with("glTF"));
  CHECK(glb.find("meshes") == std::string::npos);
  CHECK(glb.find("children") == std::string::npos);
  CHECK(glb.find("BIN") == std::string::npos);
  CHECK(glb.size() % 4 == 0);
}
