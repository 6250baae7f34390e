#include "catch.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr char kThreeParts[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no hull\nf 1 2 3\no mast\nf 1 2 4\no deck\nf 1 3 4\n";

Scenario scene(const std::filesystem::path& file, const std::vector<PartSpec>& parts) {
  Scenario scenario;
  scenario.materials = {{"steel", 0.01, {}, {}}, {"wood", 0.001, {}, {}}, {"sail", 0.1, {}, {}}};
  scenario.objects = {{"a", "x", "steel", MeshSpec{file, 1, false, false, parts}, {}},
                      {"b", "x", "steel", MeshSpec{file, 1, false, false, {}}, {}}};
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
            ": no part `mats` (did you mean mast?), accepted are hull, mast, deck\n"
            "objects.0.shape.mesh.parts.keel: " +
            file.string() + ": no part `keel`, accepted are hull, mast, deck");
}

TEST_CASE("parts cannot be told apart where there are too many") {
  const TemporaryFolder folder;
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 257; ++i) text += "o p" + std::to_string(i) + "\nf 1 2 3\n";
  const auto file = folder.write("a.obj", text);
  CHECK(build_world(scene(file, {})).ok());
  const auto world = build_world(scene(file, {{"p0", "wood"}}));
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().message.find("more than 256 names") != std::string::npos);
}
