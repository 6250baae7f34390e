// Point targets that are elastic spheres: what is read, what is written, what is refused.
#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;

std::string target(const std::string& keys) {
  return kHead + "point_targets:\n  - {name: p, position_m: [1, 0, 0], " + keys + "}\n";
}

std::string sphere(const std::string& keys) { return target("sphere: {" + keys + "}"); }

}  // namespace

TEST_CASE("spheres of every kind are read and written") {
  const auto carbide = parse(sphere("radius_m: 0.01905, material: tungsten_carbide"));
  REQUIRE(carbide.ok());
  const RingingSphereSpec& solid = carbide->point_targets[0].sphere.value();
  CHECK(solid.radius_m == 0.01905);
  CHECK(solid.metal == SphereMetal::tungsten_carbide);
  CHECK_FALSE(solid.wall_m);
  CHECK(carbide->water.density_kg_m3 == 1025);
  CHECK(emit(*carbide).find("density_kg_m3") == std::string::npos);

  const auto shell = parse(
      sphere("radius_m: 0.1, density_kg_m3: 1190, speed_m_s: 2690, shear_speed_m_s: 1340, wall_m: "
             "0.002, filling: water") +
      "water: {density_kg_m3: 1000}\n");
  REQUIRE(shell.ok());
  const RingingSphereSpec& own = shell->point_targets[0].sphere.value();
  CHECK_FALSE(own.metal);
  CHECK(own.material == SphereMaterial{1190, 2690, 1340});
  CHECK(own.wall_m == 0.002);
  CHECK(own.filling == ShellFilling::water);
  CHECK(shell->water.density_kg_m3 == 1000);

  for (const Scenario& scenario : {*carbide, *shell}) {
    const auto again = parse(emit(scenario));
    REQUIRE(again.ok());
    CHECK(emit(*again) == emit(scenario));
  }
  const auto drawn = parse(sphere("radius_m: {uniform: [0.01, 0.02]}, material: copper"));
  REQUIRE(drawn.ok());
  CHECK(drawn->point_targets[0].sphere->radius_m > 0.01);
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
  for (const auto& [text, expected] : wrong) {
    const std::string& part = expected;
    CAPTURE(text);
    const auto faults = faults_of(text);
    REQUIRE(faults.size() >= 1);
    CAPTURE(faults[0]);
    CHECK(std::any_of(faults.begin(), faults.end(), [&](const std::string& fault) {
      return fault.find(part) != std::string::npos;
    }));
  }
}

}  // namespace ensonify
