// Kinds of classes: what follows from shapes, and what a scenario states.
#include <map>

#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::kHead;

const std::string kMaterial = "materials: {m: {reflectivity: 1}}\n";

std::map<std::string, ClassKind> kinds_of(const std::string& text, std::uint32_t sequence = 0) {
  INFO(text);
  const auto scenario =
      value_of(parse_scenario(kHead + kMaterial + text, "t.yaml", ".", {}, sequence));
  REQUIRE(scenario.class_kinds.size() == scenario.class_names.size());
  std::map<std::string, ClassKind> kinds;
  for (std::size_t k = 0; k < scenario.class_names.size(); ++k) {
    kinds[scenario.class_names[k]] = scenario.class_kinds[k];
  }
  return kinds;
}

ClassKind kind_of_shape(const std::string& shape) {
  return kinds_of("objects: [{name: a, class: c, material: m, shape: " + shape + "}]\n").at("c");
}

// Protects exports from boxes around what surrounds everything, and things from losing theirs.
TEST_CASE("terrain, planes, rooms and volumes are stuff, other shapes are things") {
  for (const char* shape :
       {"{plane: {}}", "{heightfield: {size_m: [4, 4], cell_m: 1}}",
        "{box: {size_m: [1, 1, 1], inward_facing: true}}",
        "{sphere: {radius_m: 1, inward_facing: true}}",
        "{choice: [{plane: {}}, {sphere: {radius_m: {uniform: [1, 2]}, inward_facing: true}}]}"}) {
    INFO(shape);
    CHECK(kind_of_shape(shape) == ClassKind::stuff);
  }
  for (const char* shape :
       {"{box: {size_m: [1, 1, 1]}}", "{box: {size_m: [1, 1, 1], inward_facing: false}}",
        "{cylinder: {radius_m: 1, height_m: 1}}", "{model: {kind: tyre, size_m: 1}}",
        "{sphere: {radius_m: 1, inward_facing: {choice: [true, false]}}}",
        "{choice: [{plane: {}}, {sphere: {radius_m: 1}}]}"}) {
    INFO(shape);
    CHECK(kind_of_shape(shape) == ClassKind::thing);
  }
  const auto others = kinds_of(
      "point_targets: [{name: p, target_strength_db: 0, position_m: [1, 0, 0]}]\n"
      "volumes: [{name: v, uniform: {strength_db: -60}}]\n");
  CHECK(others.at("point_target") == ClassKind::thing);
  CHECK(others.at("volume") == ClassKind::stuff);
}

// Protects a class of which one object alone is a room, in whatever order and sequence.
TEST_CASE("a class with a thing in it, in any draw, is of things") {
  const std::string room = "{name: r, class: c, material: m, shape: {plane: {}}}";
  const std::string ball = "{name: b, class: c, material: m, shape: {sphere: {radius_m: 1}}}";
  const std::string both[] = {"[" + room + ", " + ball + "]", "[" + ball + ", " + room + "]",
                              "[{choice: [" + room + ", " + ball + "]}]",
                              "{choice: [[" + room + "], [" + ball + "]]}"};
  for (const std::string& objects : both) {
    for (std::uint32_t sequence = 0; sequence < 4; ++sequence) {
      CHECK(kinds_of("objects: " + objects + "\n", sequence).at("c") == ClassKind::thing);
    }
  }
  const auto sampled = kinds_of(
      "objects: [{name: r, class: {choice: [x, y]}, material: m, "
      "shape: {plane: {}}}]\n");
  CHECK(sampled.at("x") == ClassKind::stuff);
  CHECK(sampled.at("y") == ClassKind::stuff);
}

// Protects the word of the user against what shapes suggest.
TEST_CASE("a scenario states the kind of a class") {
  const std::string objects =
      "objects: [{name: r, class: quay, material: m, shape: {plane: {}}}, "
      "{name: b, class: stone, material: m, shape: {sphere: {radius_m: 1}}}, "
      "{name: w, class: wall, material: m, shape: {plane: {}}}]\n";
  const auto kinds = kinds_of(objects + "classes: {quay: {kind: thing}, stone: {kind: stuff}}\n");
  CHECK(kinds.at("quay") == ClassKind::thing);
  CHECK(kinds.at("stone") == ClassKind::stuff);
  CHECK(kinds.at("wall") == ClassKind::stuff);
}

TEST_CASE("kinds of classes are checked") {
  const std::string target =
      "point_targets: [{name: p, class: buoy, target_strength_db: 0, position_m: [1, 0, 0]}]\n";
  check_single_faults({
      {target + "classes: {bouy: {kind: thing}}",
       "5:17: classes.bouy:", "the class `bouy` (did you mean buoy?)"},
      {target + "classes: {buoy: {kind: object}}",
       "5:24: classes.buoy.kind:", "one of thing, stuff"},
      {target + "classes: {buoy: {}}", "5:17: classes.buoy.kind:", "missing"},
      {target + "classes: {buoy: {kind: {choice: [thing, stuff]}}}",
       "5:10: classes:", "cannot be sampled"},
      {target + "classes: [buoy]", "5:10: classes:", "a map of classes"},
  });
}

}  // namespace
}  // namespace ensonify
