// Scenarios of a few objects and the worlds built of them, for the tests of this folder.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "catch.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify::test {

inline ObjectSpec object(const std::string& name, ShapeSpec shape, PoseSpec pose = {}) {
  return {name, "x", "m", std::move(shape), pose};
}

// Objects of the one material m.
inline Scenario scenario_of(std::vector<ObjectSpec> objects) {
  Scenario scenario;
  scenario.seed = 11;
  scenario.materials = {{"m", 1, {}, {}}};
  scenario.objects = std::move(objects);
  return scenario;
}

// The same with objects named a, b, ...
inline Scenario scenario_of_shapes(std::vector<ShapeSpec> shapes) {
  std::vector<ObjectSpec> objects;
  for (ShapeSpec& shape : shapes) {
    objects.push_back(
        object(std::string(1, static_cast<char>('a' + objects.size())), std::move(shape)));
  }
  return scenario_of(std::move(objects));
}

inline TrajectorySpec path_from(const std::filesystem::path& file) {
  TrajectorySpec spec;
  spec.path = PathFileSpec{file};
  return spec;
}

// A file's text with these entries of `objects`.
inline Scenario scenario_of_text(std::uint64_t seed, const std::string& objects,
                                 std::uint32_t sequence) {
  const std::string head = "ensonify: 1\nname: t\nseed: " + std::to_string(seed) +
                           "\nsonar: {preset: blueview_p900_90}\n"
                           "materials: {m: {reflectivity: 1e-3}}\nobjects:\n";
  const auto scenario = parse_scenario(head + objects, "t.yaml", ".", {}, sequence);
  INFO((scenario.ok() ? "" : scenario.error().message));
  REQUIRE(scenario.ok());
  return *scenario;
}

inline World built(const Scenario& scenario, std::uint32_t sequence = 0) {
  auto world = build_world(scenario, sequence);
  INFO((world.ok() ? "" : world.error().message));
  REQUIRE(world.ok());
  return std::move(*world);
}

inline const WorldObject& object_in(const World& world, const std::string& name) {
  for (const WorldObject& o : world.objects) {
    if (world.instances[o.instance - 1].name == name) return o;
  }
  FAIL("no " + name);
  return world.objects[0];
}

inline std::shared_ptr<const Mesh> mesh_of(const World& world, int object) {
  return std::get<MeshShape>(world.objects.at(object).shape).mesh;
}

}  // namespace ensonify::test
