// Shapes of objects: terrain, models, level sets, parts of meshes.
#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::emit;
using testing::kHead;
using testing::parse;

// Line 5 is the object's; the map of the heightfield begins in column 56.
std::string with_field(const std::string& keys) {
  return "materials: {m: {reflectivity: 1}}\n"
         "objects: [{name: a, material: m, shape: {heightfield: {" +
         keys + "}}}]\n";
}

const HeightfieldSpec& field_of(const Result<Scenario>& scenario) {
  require_ok(scenario);
  return std::get<HeightfieldSpec>(scenario->objects.at(0).shape);
}

// Protects every key of a made-up seabed, read and written.
TEST_CASE("a procedural heightfield is read and written") {
  const auto first = testing::parse(
      kHead + with_field("size_m: [40, 30], cell_m: 0.1, roughness: {rms_m: 0.05, exponent: 3.5, "
                         "outer_scale_m: 12}, ripples: [{height_m: 0.05, wavelength_m: 0.4, "
                         "direction_deg: -30}, {height_m: 0, wavelength_m: 1}], normals: smooth"));
  HeightfieldSpec expected;
  expected.size_m = {40, 30};
  expected.cell_m = 0.1;
  expected.roughness = RoughnessSpec{0.05, 3.5, 12};
  expected.ripples = {{0.05, 0.4, -30}, {0, 1, 0}};
  expected.smooth_normals = true;
  CHECK(field_of(first) == expected);
  CHECK(field_of(testing::parse(emit(*first))) == expected);
  CHECK(vertices_along(expected) == std::array<int, 2>{401, 301});
  CHECK(roughness_period(expected) == std::array<std::int64_t, 2>{512, 512});
  CHECK(input_files(*first).empty());
}

// Protects every key of stones and patches, read and written, and sampled numbers in them.
TEST_CASE("stones and patches are read and written") {
  const auto scenario = testing::parse(
      kHead + with_field("size_m: [40, 30], cell_m: 0.1, patches: [{share: 0.3, correlation_m: 2, "
                         "border_m: 0.5, reflectivity_db: -6, relief_factor: 0.5}, {share: 0.1, "
                         "correlation_m: 1}], stones: [{density_per_m2: 0.4, diameter_m: [0.2, 1], "
                         "exponent: 2, aspect: [0.5, 0.9], height_ratio: [0.3, 0.6], "
                         "buried_fraction: [0, 1], reflectivity_db: 9}, {density_per_m2: 1, "
                         "diameter_m: [0.2, 0.2]}]"));
  HeightfieldSpec expected;
  expected.size_m = {40, 30};
  expected.cell_m = 0.1;
  expected.patches = {{0.3, 2, 0.5, -6, 0.5}, {0.1, 1, 0.2, 0, 1}};
  expected.stones = {{0.4, {0.2, 1}, 2, {0.5, 0.9}, {0.3, 0.6}, {0, 1}, 9}, {1, {0.2, 0.2}}};
  CHECK(field_of(scenario) == expected);
  CHECK(field_of(testing::parse(emit(*scenario))) == expected);
  const auto sampled = testing::parse(
      kHead + with_field("size_m: [40, 30], cell_m: 0.1, patches: [{share: {uniform: [0.1, 0.4]}, "
                         "correlation_m: 2}], stones: [{density_per_m2: {uniform: [0.2, 0.6]}, "
                         "diameter_m: [0.2, {uniform: [0.5, 1]}]}]"));
  const HeightfieldSpec& field = field_of(sampled);
  CHECK((field.patches[0].share > 0.1 && field.patches[0].share < 0.4));
  CHECK((field.stones[0].diameter_m[1] > 0.5 && field.stones[0].diameter_m[1] < 1));
}

TEST_CASE("what a heightfield leaves out has its default") {
  const auto flat = testing::parse(kHead + with_field("size_m: [4, 3], cell_m: 1"));
  CHECK_FALSE(field_of(flat).roughness);
  CHECK(field_of(flat).ripples.empty());
  CHECK_FALSE(field_of(flat).smooth_normals);
  CHECK(field_of(testing::parse(emit(*flat))) == field_of(flat));
  const auto rough = testing::parse(
      kHead + with_field("size_m: [4, 3], cell_m: 1, roughness: {rms_m: 0.1}, normals: face"));
  CHECK(field_of(rough).roughness == RoughnessSpec{0.1, 3, 10});
}

// Protects file terrain: found beside the scenario, listed as inputs, written back.
TEST_CASE("a heightfield from files is read and written") {
  const test::TemporaryFolder folder;
  for (const char* name : {"h.npy", "h.ASC", "m.png"}) folder.write(name, "x");
  const auto parse = [&](const std::string& text) {
    return parse_scenario(text, "t.yaml", folder.path());
  };
  const auto npy = parse(kHead + with_field("file: h.npy, cell_m: 0.5, height_scale: -0.01, "
                                            "height_offset_m: 3, reflectivity_map: m.png, patches: "
                                            "[{share: 0.5, correlation_m: 1}]"));
  HeightfieldSpec expected;
  expected.file = folder.path() / "h.npy";
  expected.cell_m = 0.5;
  expected.height_scale = -0.01;
  expected.height_offset_m = 3;
  expected.reflectivity_map = folder.path() / "m.png";
  expected.patches = {{0.5, 1}};
  CHECK(field_of(npy) == expected);
  CHECK(field_of(parse(emit(*npy))) == expected);
  CHECK(input_files(*npy) == std::vector{expected.file, expected.reflectivity_map});
  const auto asc = parse(kHead + with_field("file: h.ASC"));
  CHECK(field_of(parse(emit(*asc))) == field_of(asc));
  const auto message = [&](const std::string& keys) {
    return message_of(parse(kHead + with_field(keys)));
  };
  CHECK(contains(message("file: h.npy"), "shape.heightfield.cell_m: missing"));
  CHECK(contains(message("file: h.ASC, cell_m: 1"), "states its own"));
  CHECK(contains(message("file: h.npy, cell_m: 1, ripples: []"), "with a file"));
  CHECK(contains(
      message("file: h.npy, cell_m: 1, patches: [{share: 1, correlation_m: 9, relief_factor: 2}]"),
      "relief_factor: has no effect with a file"));
  CHECK(contains(message("file: m.png, cell_m: 1, reflectivity_map: h.ASC"), "another extension"));
  CHECK(contains(message("file: none.npy, cell_m: 1"), "does not exist"));
}

// Protects --set: terrain takes the place of another shape, a size that of a file.
TEST_CASE("an override exchanges terrain as a whole") {
  const std::string ball =
      "materials: {m: {reflectivity: 1}}\n"
      "objects: [{name: a, material: m, shape: {sphere: {radius_m: 1}}}]\n";
  const auto ground = testing::parse(
      kHead + ball, {{"objects.0.shape.heightfield", "{size_m: [4, 3], cell_m: 1}"}});
  CHECK(field_of(ground).cell_m == 1);
  const auto made = testing::parse(kHead + with_field("file: none.npy, cell_m: 1, height_scale: 2"),
                                   {{"objects.0.shape.heightfield.size_m", "[4, 3]"}});
  CHECK(field_of(made).file.empty());
}

TEST_CASE("faults of heightfields are told at their keys") {
  const std::string key = "objects.0.shape.heightfield";
  check_single_faults({
      {with_field(""), "5:55: " + key + ":", "either the file of heights or the size_m"},
      {with_field("size_m: [4, 3], cell_m: 1, file: h.npy"), "5:83: " + key + ":", "exclude"},
      {with_field("size_m: [4, 3]"), "5:55: " + key + ".cell_m:", "missing"},
      {with_field("size_m: [4, 0], cell_m: 1"), "5:68: " + key + ".size_m.1:", "a number > 0"},
      {with_field("size_m: [4, 3], cell_m: 1, height_scale: 2"),
       "5:97: " + key + ".height_scale:", "without a file"},
      {with_field("size_m: [4, 3], cell_m: 1e-9"), "5:80: " + key + ".cell_m:", "1.2e+19 vertices"},
      {with_field("size_m: [900, 500], cell_m: 0.1, roughness: {rms_m: 1}"),
       "5:84: " + key + ".cell_m:", "16384 x 8192 waves"},
      {with_field("size_m: [4, 3], cell_m: 1, roughness: {rms_m: 1, exponent: 2}"),
       "5:115: " + key + ".roughness.exponent:", "a number > 2"},
      {with_field("size_m: [4, 3], cell_m: 1, roughness: {exponent: 3}"),
       "5:94: " + key + ".roughness.rms_m:", "missing"},
      {with_field("size_m: [4, 3], cell_m: 1, ripples: [{height_m: 0, wavelength_m: 3}]"),
       "5:121: " + key + ".ripples.0.wavelength_m:", "less than 4 cells of 1 m"},
      {with_field("size_m: [4, 3], cell_m: 1, ripples: [{height_m: 2, wavelength_m: 5}]"),
       "5:104: " + key + ".ripples.0.height_m:", "too steep"},
      {with_field("size_m: [4, 3], cell_m: 1, patches: [{share: 0.5, correlation_m: 1.5}]"),
       "5:121: " + key + ".patches.0.correlation_m:", "less than 2 cells of 1 m"},
      {with_field("size_m: [4, 3], cell_m: 1, stones: [{density_per_m2: 1, diameter_m: [1, 3]}]"),
       "5:124: " + key + ".stones.0.diameter_m:", "less than 2 cells of 1 m"},
      {with_field("size_m: [4, 3], cell_m: 1, stones: [{density_per_m2: 1, diameter_m: [3, 2]}]"),
       "5:124: " + key + ".stones.0.diameter_m:", "3 is more than 2"},
      // One square metre of stones on each, at an aspect of 0.8: pi / 4 * 4 * 0.4.
      {with_field("size_m: [4, 3], cell_m: 1, stones: [{density_per_m2: 0.4, diameter_m: [2, 2]}]"),
       "5:109: " + key + ".stones.0.density_per_m2:", "cover the bed 1.01 times"},
      {with_field("size_m: [400, 300], cell_m: 0.1, stones: [{density_per_m2: 9, "
                  "diameter_m: [0.2, 0.2]}]"),
       "5:115: " + key + ".stones.0.density_per_m2:", "1.08e+06 stones"},
      {with_field("size_m: [4, 3], cell_m: 1, normals: flat"),
       "5:92: " + key + ".normals:", "face, smooth"},
  });
}

std::string object(const std::string& model) {
  return "materials: {m: {reflectivity: 1}}\n"
         "objects: [{name: a, material: m, shape: {model: " +
         model + "}}]\n";
}

// Protects data sets that are run again: every kind comes back from the resolved text.
TEST_CASE("models are read and written") {
  for (const auto& [word, kind] : kModelKinds) {
    INFO(word);
    const auto first =
        value_of(parse(kHead + object("{kind: " + std::string(word) + ", size_m: 0.35}")));
    const auto again = value_of(parse(emit(first)));
    for (const Scenario* scenario : {&first, &again}) {
      const auto* model = std::get_if<ModelSpec>(&scenario->objects[0].shape);
      REQUIRE(model != nullptr);
      CHECK(model->kind == kind);
      CHECK(model->size_m == 0.35);
    }
    CHECK(emit(first) == emit(again));
  }
}

TEST_CASE("wrong models are faults at their key") {
  check_single_faults({
      {object("{kind: boot, size_m: 1}"),
       "5:56: objects.0.shape.model.kind:", "one of bottle, can, tyre, chain, hook, propeller"},
      {object("{size_m: 1}"), "5:49: objects.0.shape.model.kind:", "one of bottle"},
      {object("{kind: can}"), "5:49: objects.0.shape.model.size_m:", "a number > 0"},
      {object("{kind: can, size_m: 0}"), "5:69: objects.0.shape.model.size_m:", "a number > 0"},
      {object("{kind: can, size_m: 1, size: 2}"),
       "5:72: objects.0.shape.model.size:", "did you mean size_m?"},
  });
}

std::string with_shape(const std::string& shape) {
  return kHead +
         "materials: {m: {reflectivity: 1}}\n"
         "objects: [{name: a, material: m, shape: {" +
         shape + "}}]\n";
}

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
    const auto again = value_of(parse_scenario(emit(*scenario), "t.yaml", folder.path()));
    CHECK(emit(again) == emit(*scenario));
  }
  CHECK(std::get<LevelSetSpec>(named->objects[0].shape).grid == "the hull");
  const auto replaced =
      value_of(read("box: {size_m: [1, 1, 1]}", {{"objects.0.shape.level_set.file", "a.vdb"}}));
  CHECK(std::holds_alternative<LevelSetSpec>(replaced.objects[0].shape));
}

TEST_CASE("wrong level sets are faults at their place") {
  const test::TemporaryFolder folder;
  folder.write("a.vdb", "");
  folder.write("a.obj", "");
  const auto fault = [&](const std::string& keys) {
    return message_of(
        parse_scenario(with_shape("level_set: {" + keys + "}"), "t.yaml", folder.path()));
  };
  CHECK(contains(fault("grid: a"), "objects.0.shape.level_set.file: missing"));
  CHECK(contains(fault("file: a.obj"), "has another extension"));
  CHECK(contains(fault("file: a.vdb, adaptivity: 0.5"), "level_set.adaptivity: unknown key"));
}

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
  std::string fault(const std::string& parts) const { return message_of(read(with_parts(parts))); }
};

const std::vector<PartSpec>& parts_of(const Result<Scenario>& scenario) {
  require_ok(scenario);
  return std::get<MeshSpec>(scenario->objects[0].shape).parts;
}

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
  CHECK(contains(emit(*scenario), "parts: {hull: steel, \"no 1\": wood, file: steel}"));
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
                         "you mean steel?); "
                         "expected one of the keys of materials: steel, wood"));
  CHECK(contains(folder.fault("[steel]"), "objects.0.shape.mesh.parts: not a map"));
  CHECK(contains(folder.fault("{hull: [steel]}"), "mesh.parts.hull:"));
}

}  // namespace
}  // namespace ensonify
