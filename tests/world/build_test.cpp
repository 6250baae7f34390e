#include "catch.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects ids: instances count objects, then point targets, in the order of the scenario; classes
// in order of appearance, shared by name.
TEST_CASE("instances and classes are numbered in order") {
  Scenario scenario;
  scenario.materials = {{"steel", 0.01}, {"sand", 0.001}};
  scenario.objects = {{"a", "pipe", "steel", SphereSpec{1, false}, {}},
                      {"b", "floor", "sand", PlaneSpec{}, {}},
                      {"c", "pipe", "steel", CylinderSpec{1, 4}, {}}};
  scenario.point_targets = {{"t", "buoy", -30, {1, 2, 3}}};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  CHECK(world->classes == std::vector<std::string>{"pipe", "floor", "buoy"});
  REQUIRE(world->instances.size() == 4);
  CHECK(world->instances[2].id == 3);
  CHECK(world->instances[2].class_id == 1);
  CHECK(world->instances[3].point_target);
  CHECK(world->objects[1].reflectivity == 0.001);
  CHECK(world->point_targets[0].instance == 4);
  CHECK(std::get<CylinderShape>(world->objects[2].shape).half_height_m == 2);
}

TEST_CASE("equal meshes are read once") {
  const TemporaryFolder folder;
  const auto file = folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  Scenario scenario;
  scenario.materials = {{"m", 1}};
  scenario.objects = {{"a", "x", "m", MeshSpec{file, 1, false}, {}},
                      {"b", "x", "m", MeshSpec{file, 1, false}, {}},
                      {"c", "x", "m", MeshSpec{file, 2, false}, {}}};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  const auto mesh = [&](int i) { return std::get<MeshShape>(world->objects[i].shape).mesh; };
  CHECK(mesh(0) == mesh(1));
  CHECK(mesh(0) != mesh(2));
}
