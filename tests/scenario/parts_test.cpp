#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::kHead;

std::string with_parts(const std::string& parts) {
  return kHead +
         "materials: {steel: {reflectivity: 1}, wood: {reflectivity: 1}}\n"
         "objects: [{name: a, material: wood, shape: {mesh: {file: a.obj, parts: " +
         parts + "}}}]\n";
}

struct Folder : test::TemporaryFolder {
  Folder() { write("a.obj", "v 0 0 0\n"); }
  Result<Scenario> read(const std::string& text,
                        const std::vector<Override>& overrides = {}) const {
    return parse_scenario(text, "t.yaml", path(), overrides);
  }
  std::string fault(const std::string& parts) const {
    const auto scenario = read(with_parts(parts));
    return scenario ? "" : scenario.error().message;
  }
};

const std::vector<PartSpec>& parts_of(const Result<Scenario>& scenario) {
  INFO((scenario ? "" : scenario.error().message));
  REQUIRE(scenario.ok());
  return std::get<MeshSpec>(scenario->objects[0].shape).parts;
}

}  // namespace

// Protects the names of parts, which are the file's: no word of ours has a meaning among them.
TEST_CASE("parts of a mesh name their materials") {
  const Folder folder;
  const auto scenario = folder.read(with_parts("{hull: steel, \"no 1\": wood, file: steel}"));
  const auto& parts = parts_of(scenario);
  REQUIRE(parts.size() == 3);
  CHECK(parts[0].part == "hull");
  CHECK(parts[0].material == "steel");
  CHECK(parts[1].part == "no 1");
  CHECK(parts[2].part == "file");
  const auto again = folder.read(emit(*scenario));
  CHECK(parts_of(again).size() == 3);
  CHECK(emit(*again) == emit(*scenario));
  CHECK(emit(*scenario).find("parts: {hull: steel, \"no 1\": wood, file: steel}") !=
        std::string::npos);
}

TEST_CASE("materials of parts are overridden and drawn") {
  const Folder folder;
  const auto set = folder.read(
      with_parts("{box: steel}"),
      {{"objects.0.shape.mesh.parts.mesh", "wood"}, {"objects.0.shape.mesh.parts.box", "wood"}});
  REQUIRE(parts_of(set).size() == 2);
  CHECK(parts_of(set)[0].material == "wood");
  const auto drawn = folder.read(with_parts("{file: {choice: [steel]}}"));
  CHECK(parts_of(drawn)[0].material == "steel");
  CHECK(input_files(*drawn).size() == 1);
}

TEST_CASE("wrong parts are faults at their place") {
  const Folder folder;
  CHECK(folder.fault("{}").empty());

  CHECK(folder.fault("{hull: stel}")
            .starts_with("t.yaml:5:79: objects.0.shape.mesh.parts.hull: no material `stel` (did "
                         "you mean steel?), "
                         "accepted are the keys of materials: steel, wood"));
  CHECK(folder.fault("[steel]").find("objects.0.shape.mesh.parts: no map") != std::string::npos);
  CHECK(folder.fault("{hull: [steel]}").find("mesh.parts.hull:") != std::string::npos);
}

}  // namespace ensonify
