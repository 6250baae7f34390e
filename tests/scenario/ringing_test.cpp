// Point targets and objects that are elastic: what is read, what is written, what is refused.
#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;
using testing::read_again;

std::string target(const std::string& keys) {
  return kHead + "point_targets:\n  - {name: p, position_m: [1, 0, 0], " + keys + "}\n";
}

std::string sphere(const std::string& keys) { return target("sphere: {" + keys + "}"); }

}  // namespace

TEST_CASE("spheres of every kind are read and written") {
  const auto carbide = value_of(parse(sphere("radius_m: 0.01905, material: tungsten_carbide")));
  const RingingSphereSpec& solid = carbide.point_targets[0].sphere.value();
  CHECK(solid.radius_m == 0.01905);
  CHECK(solid.metal == SphereMetal::tungsten_carbide);
  CHECK_FALSE(solid.wall_m);
  CHECK(carbide.water.density_kg_m3 == 1025);
  CHECK_FALSE(contains(emit(carbide), "density_kg_m3"));

  const auto shell = value_of(parse(
      sphere("radius_m: 0.1, density_kg_m3: 1190, speed_m_s: 2690, shear_speed_m_s: 1340, wall_m: "
             "0.002, filling: water") +
      "water: {density_kg_m3: 1000}\n"));
  const RingingSphereSpec& own = shell.point_targets[0].sphere.value();
  CHECK_FALSE(own.metal);
  CHECK(own.material == SphereMaterial{1190, 2690, 1340});
  CHECK(own.wall_m == 0.002);
  CHECK(own.filling == ShellFilling::water);
  CHECK(shell.water.density_kg_m3 == 1000);

  for (const Scenario& scenario : {carbide, shell}) {
    read_again(scenario);
  }
  const auto drawn = value_of(parse(sphere("radius_m: {uniform: [0.01, 0.02]}, material: copper")));
  CHECK(drawn.point_targets[0].sphere->radius_m > 0.01);
}

TEST_CASE("spheres that cannot be are refused") {
  const std::string own = "radius_m: 0.1, density_kg_m3: 1190, speed_m_s: 2690, ";
  const std::string steel = "radius_m: 0.1, material: steel";
  const std::pair<std::string, std::string> wrong[] = {
      {target("class: ball"), "either target_strength_db or an elastic sphere"},
      {target("target_strength_db: -40, sphere: {" + steel + "}"), "target_strength_db"},
      {sphere("radius_m: 0.1"), "either material or density_kg_m3"},
      {sphere("radius_m: 0.1, material: lead"), "tungsten_carbide, steel, aluminum"},
      {sphere("radius_m: 0.1, density_kg_m3: 1190, speed_m_s: 2690"), "shear_speed_m_s"},
      {sphere(own + "shear_speed_m_s: 2500"), "expected less than 2329.61"},
      {sphere(steel + ", speed_m_s: 5900"), "with material"},
      {sphere(steel + ", wall_m: 0.1"), "expected a thinner wall"},
      {sphere(steel + ", filling: air"), "without wall_m"},
      {sphere("radius_m: 0, material: steel"), "radius_m"},
  };
  for (const auto& [text, part] : wrong) {
    CAPTURE(text);
    check_fails(parse(text), {part});
  }
}

namespace {
std::string elastic_object(const std::string& shape, const std::string& elastic,
                           const std::string& material = "{reflectivity: 0}") {
  return kHead + "materials: {m: " + material + "}\nobjects: [{name: body, material: m, shape: {" +
         shape + "}, elastic: {" + elastic + "}}]\n";
}
}  // namespace

TEST_CASE("spheres and cylinders may be elastic, and nothing else may") {
  const std::string rod = "cylinder: {radius_m: 0.1, height_m: 1}";
  const auto shell =
      value_of(parse(elastic_object(rod, "material: steel, wall_m: 0.003, filling: water")));
  REQUIRE(shell.objects[0].elastic);
  CHECK(shell.objects[0].elastic->metal == SphereMetal::steel);
  CHECK(shell.objects[0].elastic->filling == ShellFilling::water);
  read_again(shell);
  CHECK(parse(elastic_object("sphere: {radius_m: 0.1}", "material: copper")).ok());

  const std::string steel = "material: steel";
  const std::pair<std::string, std::string> wrong[] = {
      {elastic_object("box: {size_m: [1, 1, 1]}", steel), "the shape has no resonances"},
      {elastic_object("sphere: {radius_m: 2}", steel), "the radius of 2 is too large"},
      {elastic_object("sphere: {radius_m: 0.5, inward_facing: true}", steel), "has no resonances"},
      {elastic_object(rod, steel + ", wall_m: 0.2"), "expected a thinner wall"},
      {elastic_object(rod, "wall_m: 0.01"), "either material or density_kg_m3"},
      {elastic_object(rod, steel,
                      "{reflectivity: 0, growth: {material: steel_smooth, cover: 0.5, "
                      "correlation_m: 0.1}}"),
       "the material `steel_smooth` has a specular echo"},
      {elastic_object(rod, steel, "{reflectivity: 1, coherent: {model: kirchhoff}}"),
       "objects.0.elastic: the material `m` has a specular echo"},
      {elastic_object(rod, steel,
                      "{reflectivity: 1, wall: {thickness_m: 0.003, density_kg_m3: 7850, "
                      "speed_m_s: 5900, shear_speed_m_s: 3230}}"),
       "the material `m` has a wall"},
  };
  for (const auto& [text, part] : wrong) {
    CAPTURE(text);
    check_fails(parse(text), {part});
  }
}

// One error, not what follows from it.
TEST_CASE("an elastic cylinder without a radius is one error") {
  const auto faults =
      faults_of(elastic_object("cylinder: {height_m: 1}", "material: steel, wall_m: 0.01"));
  REQUIRE(faults.size() == 1);
  CHECK(contains(faults[0], "radius_m: missing"));
}

}  // namespace ensonify
