#include <sstream>

#include "catch.h"
#include "is_refused.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects ids: instances count objects, then point targets, then volumes, in the order of the
// scenario; classes in order of appearance, shared by name.
TEST_CASE("instances and classes are numbered in order") {
  Scenario scenario;
  scenario.materials = {{"steel", 0.01, {}, {}}, {"sand", 0.001, {}, {}}};
  scenario.objects = {{"a", "pipe", "steel", SphereSpec{1, false}, {}},
                      {"b", "floor", "sand", PlaneSpec{}, {}},
                      {"c", "pipe", "steel", CylinderSpec{1, 4}, {}}};
  scenario.point_targets = {{"t", "buoy", -30, {1, 2, 3}}};
  scenario.volumes = {{"w", "floor", UniformVolumeSpec{-60, {}, 0}, {}}};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  CHECK(world->classes == std::vector<std::string>{"pipe", "floor", "buoy"});
  REQUIRE(world->instances.size() == 5);
  CHECK(world->instances[4].kind == InstanceKind::volume);
  CHECK(world->instances[4].class_id == 2);
  CHECK(world->instances[4].volume_strength_db == -60);
  REQUIRE(world->volumes.size() == 1);
  CHECK(world->volumes[0].instance == 5);
  CHECK(world->volumes[0].strength_per_m == Approx(1e-6));
  CHECK(world->instances[2].id == 3);
  CHECK(world->instances[2].class_id == 1);
  CHECK(world->instances[3].kind == InstanceKind::point_target);
  CHECK(world->instances[3].target_strength_db == -30);
  CHECK(world->objects[1].material.reflectivity == 0.001);
  CHECK(world->point_targets[0].instance == 4);
  CHECK(std::get<CylinderShape>(world->objects[2].shape).half_height_m == 2);
}

TEST_CASE("equal meshes are read once") {
  const TemporaryFolder folder;
  const auto file = folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const MeshSpec mesh{file, {1, 1, 1}, false, false}, larger{file, {2, 2, 2}, false, false};
  const World world = built(scenario_of_shapes({mesh, mesh, larger}));
  CHECK(mesh_of(world, 0) == mesh_of(world, 1));
  CHECK(mesh_of(world, 0) != mesh_of(world, 2));
}

namespace {

std::string table(double strength_db) {
  std::string text = "grazing_deg,strength_db\n";
  for (int angle = 0; angle <= 90; angle += 10) {
    text += std::to_string(angle) + "," + std::to_string(strength_db + angle) + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("tables of materials reach objects and instances") {
  const TemporaryFolder folder;
  Scenario scenario;
  scenario.materials = {
      {"sand", 0, MeasuredStrength{folder.write("sand.csv", table(-40))}, {}}};
  scenario.objects = {{"floor", "floor", "sand", PlaneSpec{}, {}}};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  const auto rows = [](const Material& material) {
    return std::get<MeasuredStrength>(material.law).table;
  };
  REQUIRE(rows(world->objects[0].material).strength_db.size() == 10);
  CHECK(rows(world->objects[0].material).strength_db[1] == -30);
  CHECK(rows(world->instances[0].scattering).grazing_rad.size() == 10);
}

TEST_CASE("vertex colours are read where an object asks for them") {
  const TemporaryFolder folder;
  const auto file =
      folder.write("t.obj", "v 0 0 0 1 1 1\nv 1 0 0 0 0 0\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n");
  const World world = built(scenario_of_shapes(
      {MeshSpec{file, {1, 1, 1}, false, false}, MeshSpec{file, {1, 1, 1}, false, true}}));
  CHECK(mesh_of(world, 0)->reflectivity.empty());
  CHECK(mesh_of(world, 1)->reflectivity.size() == 3);
  CHECK_FALSE(world.instances[0].vertex_reflectivity);
  CHECK(world.instances[1].vertex_reflectivity);
}

// Protects users from mending one file after the other: every line of every fault, behind its key.
TEST_CASE("all faults of the input files are told at once") {
  const TemporaryFolder folder;
  const auto plain = folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  Scenario scenario;
  scenario.materials = {
      {"mud",
       0,
       MeasuredStrength{folder.write("mud.csv", "grazing_deg,strength_db\n5,x\n6,y\n")},
       {}},
      {"sand", 0, MeasuredStrength{folder.path() / "none.csv"}, {}}};
  scenario.objects = {{"a", "x", "mud", MeshSpec{plain, {1, 1, 1}, false, true}, {}},
                      {"b", "x", "mud", MeshSpec{folder.path() / "none.obj", {1, 1, 1}, false, false}, {}}};
  const auto world = build_world(scenario);
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().kind == ErrorKind::usage);
  std::istringstream message(world.error().message);
  std::vector<std::string> keys;
  for (std::string line; std::getline(message, line);) {
    INFO(line);
    const std::string key = line.substr(0, line.find(": "));
    CHECK(key.ends_with("file"));
    if (keys.empty() || keys.back() != key) keys.push_back(key);
  }
  CHECK(keys == std::vector<std::string>{"materials.mud.law.table.file",
                                         "materials.sand.law.table.file",
                                         "objects.0.shape.mesh.file", "objects.1.shape.mesh.file"});
}

namespace {

constexpr char kThreeParts[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no hull\nf 1 2 3\no mast\nf 1 2 4\no deck\nf 1 3 4\n";

Scenario scene(const std::filesystem::path& file, const std::vector<PartSpec>& parts) {
  Scenario scenario;
  scenario.materials = {{"steel", 0.01, {}, {}}, {"wood", 0.001, {}, {}}, {"sail", 0.1, {}, {}}};
  scenario.objects = {{"a", "x", "steel", MeshSpec{file, {1, 1, 1}, false, false, parts}, {}},
                      {"b", "x", "steel", MeshSpec{file, {1, 1, 1}, false, false, {}}, {}}};
  return scenario;
}

}  // namespace

// Protects instancing: what parts scatter with is the object's, the mesh is the same for all.
TEST_CASE("parts have materials of their own on one object and none on the next") {
  const TemporaryFolder folder;
  const auto world =
      build_world(scene(folder.write("a.obj", kThreeParts), {{"mast", "wood"}, {"hull", "steel"}}));
  REQUIRE(world.ok());
  const PartMaterials& parts = world->objects[0].parts;
  CHECK(parts.of_part == std::vector<std::uint16_t>{0, 1, 0});
  REQUIRE(parts.materials.size() == 1);
  CHECK(parts.materials[0].reflectivity == 0.001);
  CHECK(world->objects[1].parts.of_part.empty());
  CHECK(std::get<MeshShape>(world->objects[0].shape).mesh ==
        std::get<MeshShape>(world->objects[1].shape).mesh);
  REQUIRE(world->instances[0].parts.size() == 2);
  CHECK(world->instances[0].parts[0].name == "mast");
  CHECK(world->instances[0].parts[0].material == "wood");
  CHECK(world->instances[0].parts[1].scattering.reflectivity == 0.01);
  CHECK(world->instances[1].parts.empty());
}

TEST_CASE("parts of one material are one") {
  const TemporaryFolder folder;
  const auto world = build_world(scene(folder.write("a.obj", kThreeParts),
                                       {{"deck", "sail"}, {"mast", "wood"}, {"hull", "sail"}}));
  REQUIRE(world.ok());
  CHECK(world->objects[0].parts.of_part == std::vector<std::uint16_t>{1, 2, 1});
  CHECK(world->objects[0].parts.materials.size() == 2);
}

// Protects users whose file names its parts otherwise than they thought.
TEST_CASE("an unknown part is a fault that lists the parts of the file") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.obj", kThreeParts);
  const auto world = build_world(scene(file, {{"mats", "wood"}, {"keel", "sail"}}));
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().kind == ErrorKind::usage);
  CHECK(world.error().message ==
        "objects.0.shape.mesh.parts.mats: " + file.string() +
            ": has no part `mats` (did you mean mast?); expected one of hull, mast, deck\n"
            "objects.0.shape.mesh.parts.keel: " +
            file.string() + ": has no part `keel`; expected one of hull, mast, deck");
}

TEST_CASE("parts cannot be told apart where there are too many") {
  const TemporaryFolder folder;
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 257; ++i) text += "o p" + std::to_string(i) + "\nf 1 2 3\n";
  const auto file = folder.write("a.obj", text);
  CHECK(build_world(scene(file, {})).ok());
  const auto world = build_world(scene(file, {{"p0", "wood"}}));
  CHECK(is_refused(world, "more than 256 names"));
}
