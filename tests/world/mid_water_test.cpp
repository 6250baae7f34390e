// Objects that are placed in the water or on a heap of others.
#include <algorithm>
#include <cmath>
#include <string>

#include "catch.h"
#include "core/units.h"
#include "is_refused.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "world/ground.h"
#include "world/outline.h"
#include "world/world.h"

using namespace ensonify;

namespace {

World built_of(const std::string& objects, std::uint32_t sequence = 0) {
  return test::built(test::scenario_of_text(5, objects, sequence), sequence);
}

double lowest(const WorldObject& o) {
  return o.pose.position_m.z + outline_of(o.shape, o.pose.rotation).low_m;
}

}  // namespace

// Protects the distribution in a box of water: means and variances of each coordinate within three
// standard errors of a uniform one's, independent of each other.
TEST_CASE("places in a volume are uniform") {
  const double from[] = {1, -2, -5}, to[] = {3, 2, -4};
  std::vector<double> x[3];
  for (std::uint32_t sequence = 0; sequence < 2000; ++sequence) {
    const World world = built_of(
        "  - {name: ball, material: m, shape: {sphere: {radius_m: 0.1}}, place: {volume_m: "
        "[[1, -2, -5], [3, 2, -4]]}}\n",
        sequence);
    const Vec3 p = world.objects[0].pose.position_m;
    x[0].push_back(p.x), x[1].push_back(p.y), x[2].push_back(p.z);
  }
  const double n = 2000;
  double mean[3] = {};
  for (int i = 0; i < 3; ++i) {
    const double width = to[i] - from[i];
    double square = 0;
    for (const double v : x[i]) mean[i] += v / n;
    for (const double v : x[i]) square += (v - mean[i]) * (v - mean[i]) / n;
    CHECK(*std::min_element(x[i].begin(), x[i].end()) >= from[i]);
    CHECK(*std::max_element(x[i].begin(), x[i].end()) <= to[i]);
    CHECK(std::abs(mean[i] - (from[i] + to[i]) / 2) < 3 * width / std::sqrt(12 * n));
    CHECK(std::abs(square / (width * width) - 1.0 / 12) < 3 * std::sqrt(1.0 / 180 / n));
  }
  double product = 0;
  for (int k = 0; k < 2000; ++k) product += (x[0][k] - mean[0]) * (x[2][k] - mean[2]) / n;
  CHECK(std::abs(product) < 3 * 2 * 1 / 12.0 / std::sqrt(n));
}

// Protects against objects in each other: balls that overlap seen from above may pass at different
// heights, and none comes nearer than the clearance, to the terrain and to planes as well.
TEST_CASE("objects in mid-water are clear of each other, of terrain and of planes") {
  const std::string objects =
      "  - {name: bed, material: m, shape: {heightfield: {size_m: [8, 8], cell_m: 0.2, roughness: "
      "{rms_m: 0.3}}}, pose: {position_m: [0, 0, -3]}}\n"
      "  - {name: surface, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, 0]}}\n"
      "  - {name: ball, count: 30, material: m, shape: {sphere: {radius_m: 0.25}}, place: "
      "{volume_m: "
      "[[-2, -2, -4], [2, 2, 1]], clearance_m: 0.1}}\n";
  int above_each_other = 0, above_surface = 0;
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    const World world = built_of(objects, sequence);
    REQUIRE(world.objects.size() == 32);
    const Ground bed(world.objects[0].shape, world.objects[0].pose);
    for (std::size_t i = 2; i < 32; ++i) {
      const Vec3 p = world.objects[i].pose.position_m;
      CHECK(std::abs(p.z) >= 0.35 - 1e-12);
      above_surface += p.z > 0 ? 1 : 0;
      CHECK(p.z - 0.25 >= bed.at(p.x, p.y)->height_m + 0.1 - 1e-9);
      for (std::size_t j = i + 1; j < 32; ++j) {
        const Vec3 d = p - world.objects[j].pose.position_m;
        const bool apart = std::hypot(d.x, d.y) >= 0.6 - 1e-9;
        CHECK((apart || std::abs(d.z) >= 0.6 - 1e-9));
        above_each_other += apart ? 0 : 1;
      }
    }
  }
  CHECK(above_each_other > 20);
  CHECK(above_surface > 5);
}

TEST_CASE("a volume without room is told") {
  const Scenario crowded = test::scenario_of_text(
      5,
      "  - {name: post, material: m, shape: {box: {size_m: [4, 4, 4]}}}\n"
      "  - {name: ball, material: m, shape: {sphere: {radius_m: 0.25}}, place: {volume_m: "
      "[[-1, -1, -1], [1, 1, 1]], on_failure: error}}\n",
      0);
  const auto world = build_world(crowded);
  CHECK(test::is_refused(world, "200 times too close to another object, most often post",
                         ErrorKind::final_usage));
  CHECK(test::is_refused(world, "make volume_m larger"));
}

// A height above the ground: as high above where the same draws put it without.
TEST_CASE("a height raises an object above its place") {
  const auto at = [](const std::string& height) {
    return built_of(
               "  - {name: floor, material: m, shape: {plane: {}}, pose: {rotation_deg: [0, 10, "
               "0]}}\n"
               "  - {name: box, material: m, shape: {box: {size_m: [1, 0.5, 0.3]}}, place: {on: "
               "floor, "
               "area_m: [[-5, -5], [5, 5]]" +
               height + "}}\n")
        .objects[1]
        .pose;
  };
  const Pose stands = at(""), floats = at(", height_m: 1.5");
  CHECK(floats.rotation == stands.rotation);
  CHECK(floats.position_m.x == stands.position_m.x);
  CHECK(floats.position_m.z == Approx(stands.position_m.z + 1.5).epsilon(1e-14));
}

// Closed forms of a heap: over one point boxes stack and balls stand on balls.
TEST_CASE("objects on a heap lie on each other") {
  const auto heights = [](const std::string& shape) {
    const World world = built_of(
        "  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}\n"
        "  - {name: thing, count: 4, material: m, shape: " +
        shape + ", place: {on: floor, heap: true, area_m: [[1, 1], [1, 1]]}}\n");
    std::vector<double> z;
    for (std::size_t i = 1; i < world.objects.size(); ++i) z.push_back(lowest(world.objects[i]));
    return z;
  };
  const std::vector<double> boxes = heights("{box: {size_m: [1, 1, 0.3]}}");
  const std::vector<double> balls = heights("{sphere: {radius_m: 0.2}}");
  REQUIRE(boxes.size() == 4);
  REQUIRE(balls.size() == 4);
  for (int i = 0; i < 4; ++i) {
    CHECK(boxes[i] == Approx(-2 + 0.3 * i).margin(1e-9));
    CHECK(balls[i] == Approx(-2 + 0.4 * i).margin(1e-9));
  }
}

// A heap over an area: each thing touches what is below it, and no point of one is within another
// by more than what the contact points leave open.
TEST_CASE("nothing in a heap is within another thing") {
  int raised = 0;
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    const World world = built_of(
        "  - {name: floor, material: m, shape: {plane: {}}}\n"
        "  - {name: ball, count: 12, material: m, shape: {sphere: {radius_m: 0.2}}, place: {on: "
        "floor, "
        "heap: true, area_m: [[-0.5, -0.5], [0.5, 0.5]]}}\n",
        sequence);
    for (std::size_t i = 1; i < world.objects.size(); ++i) {
      const Vec3 p = world.objects[i].pose.position_m;
      double nearest = p.z;  // the floor's distance, less a radius
      nearest -= 0.2;
      CHECK(nearest >= -1e-9);
      for (std::size_t j = 1; j < world.objects.size(); ++j) {
        if (i == j) continue;
        const double gap = length(p - world.objects[j].pose.position_m) - 0.4;
        CHECK(gap > -3e-3);  // where balls meet almost side by side
        if (j < i) nearest = std::min(nearest, gap);
      }
      CHECK(nearest < 1e-2);
      raised += p.z > 0.21 ? 1 : 0;
    }
  }
  CHECK(raised > 30);
}
