#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::kHead;

std::string with_shape(const std::string& shape) {
  return kHead +
         "materials: {m: {reflectivity: 1}}\n"
         "objects: [{name: a, material: m, shape: {" +
         shape + "}}]\n";
}

}  // namespace

TEST_CASE("level sets are read, written and read again") {
  const test::TemporaryFolder folder;
  folder.write("a.vdb", "");
  const auto read = [&](const std::string& shape, const std::vector<Override>& overrides = {}) {
    return parse_scenario(with_shape(shape), "t.yaml", folder.path(), overrides);
  };
  const auto plain = read("level_set: {file: a.vdb}");
  REQUIRE(plain.ok());
  CHECK(std::get<LevelSetSpec>(plain->objects[0].shape).grid.empty());
  CHECK(std::get<LevelSetSpec>(plain->objects[0].shape).smooth_normals);
  CHECK(input_files(*plain).size() == 1);
  const auto named = read("level_set: {file: a.vdb, grid: \"the hull\", normals: face}");
  REQUIRE(named.ok());
  for (const auto& scenario : {plain, named}) {
    const auto again = parse_scenario(emit(*scenario), "t.yaml", folder.path());
    REQUIRE(again.ok());
    CHECK(emit(*again) == emit(*scenario));
  }
  CHECK(std::get<LevelSetSpec>(named->objects[0].shape).grid == "the hull");
  const auto replaced =
      read("box: {size_m: [1, 1, 1]}", {{"objects.0.shape.level_set.file", "a.vdb"}});
  REQUIRE(replaced.ok());
  CHECK(std::holds_alternative<LevelSetSpec>(replaced->objects[0].shape));
}

TEST_CASE("wrong level sets are faults at their place") {
  const test::TemporaryFolder folder;
  folder.write("a.vdb", "");
  folder.write("a.obj", "");
  const auto fault = [&](const std::string& keys) {
    const auto scenario =
        parse_scenario(with_shape("level_set: {" + keys + "}"), "t.yaml", folder.path());
    return scenario ? "" : scenario.error().message;
  };
  CHECK(fault("grid: a").find("objects.0.shape.level_set.file: missing") != std::string::npos);
  CHECK(fault("file: a.obj").find("has another ending") != std::string::npos);
  CHECK(fault("file: a.vdb, adaptivity: 0.5").find("level_set.adaptivity: unknown key") !=
        std::string::npos);
}

}  // namespace ensonify
