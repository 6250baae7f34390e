// Uneven surfaces as rays meet them: which material and which texture a hit has, and that both are
// fixed to the object.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "catch.h"
#include "scenario/scenario.h"
#include "trace/tracer.h"

using namespace ensonify;

namespace {

World world_with(const std::string& materials) {
  const auto scenario = parse_scenario(
      "ensonify: 1\nsonar: {preset: blueview_p900_90}\nmaterials: " + materials +
          "\nobjects:\n  - {name: wall, material: wall, shape: {box: {size_m: [1, 8, 8]}}, "
          "pose: {position_m: [5, 0, 0]}}\n",
      "wall.yaml", ".");
  if (!scenario) FAIL(scenario.error().message);
  auto world = build_world(*scenario);
  if (!world) FAIL(world.error().message);
  return std::move(*world);
}

// Of rays over the wall's face, from a sonar at the origin.
std::vector<Hit> hits_on(const Tracer& tracer, Vec3 from_m = {}) {
  std::vector<Hit> hits;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      const Vec3 aim{4.5, 3.9 * (i / 20.0 - 1), 3.9 * (j / 20.0 - 1)};
      hits.push_back(tracer.first_hit({from_m, normalized(aim)}, 20));
    }
  }
  return hits;
}

}  // namespace

TEST_CASE("what grows has its own material and its own texture") {
  const std::string base =
      "{wall: {reflectivity: 1, texture: {model: lognormal, spread_db: 6, correlation_m: 0.3}, "
      "growth: {material: weed, cover: 0.4, correlation_m: 0.5}}, weed: {reflectivity: 2";
  const World even = world_with(base + "}}");
  int grown = 0;
  for (const Hit& hit : hits_on(Tracer(even))) {
    REQUIRE(hit.instance == 1);
    CHECK((hit.part == 0) == (hit.reflectivity != 1));  // the weed has no texture
    grown += hit.part != 0;
  }
  CHECK(even.objects[0].parts.materials.at(0).reflectivity == 2);
  // Some 60 independent patches.
  CHECK(grown / 1600.0 == Approx(0.4).margin(0.25));

  const World uneven =
      world_with(base + ", texture: {model: gamma, shape: 2, correlation_m: 0.1}}}");
  std::vector<float> factors;
  for (const Hit& hit : hits_on(Tracer(uneven))) {
    if (hit.part != 0) factors.push_back(hit.reflectivity);
  }
  std::sort(factors.begin(), factors.end());
  CHECK(std::unique(factors.begin(), factors.end()) - factors.begin() > grown / 2);
}

TEST_CASE("a texture moves with its object") {
  const World world = world_with(
      "{wall: {reflectivity: 1, texture: {model: gamma, shape: 1, correlation_m: 0.2}}}");
  const Tracer at_rest(world);
  const Quat turn = from_roll_pitch_yaw(0.3, -0.2, 0.5);
  const Pose moved{{100, -20, 7}, turn};
  const Pose wall = compose(moved, world.objects[0].pose);
  const Tracer tracer = at_rest.at(std::vector{wall});
  const auto before = hits_on(at_rest);
  int different = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3 aim{4.5, 3.9 * (static_cast<double>(i / 40) / 20.0 - 1),
                   3.9 * (static_cast<double>(i % 40) / 20.0 - 1)};
    const Hit after = tracer.first_hit({moved.position_m, rotate(turn, normalized(aim))}, 20);
    CHECK(after.reflectivity == Approx(before[i].reflectivity).epsilon(1e-4));
    different += std::abs(before[i].reflectivity - before[0].reflectivity) > 0.01f;
  }
  CHECK(different > 1500);
}

TEST_CASE("hits behind others have the texture too") {
  const World world = world_with(
      "{wall: {reflectivity: 1, texture: {model: gamma, shape: 1, correlation_m: 0.2}}}");
  const Tracer tracer(world);
  for (const double y : {-2.0, 0.3, 1.7}) {
    const Ray ray{{0, y, 0.4}, {1, 0, 0}};
    const auto along = tracer.hits_along(ray, 20);
    REQUIRE(along.size() == 1);
    CHECK(along[0].reflectivity == tracer.first_hit(ray, 20).reflectivity);
    CHECK(along[0].reflectivity != 1);
  }
}
