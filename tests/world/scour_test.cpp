#include "world/scour.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "world/ground.h"

using namespace ensonify;

namespace {

HeightGrid flat_grid(int side, double cell_m) {
  return {side, side, cell_m, std::vector<double>(std::size_t(side) * side)};
}

double& height(HeightGrid& grid, double x_m, double y_m) {
  const int column = static_cast<int>(std::lround(x_m / grid.cell_m + 0.5 * (grid.columns - 1)));
  const int row = static_cast<int>(std::lround(0.5 * (grid.rows - 1) - y_m / grid.cell_m));
  return grid.heights_m.at(std::size_t(row) * grid.columns + column);
}

const Shape kBox = BoxShape{{0.5, 0.3, 0.2}};

}  // namespace

// Protects the volume: what is dug out of the pit is in the mound, around any convex outline, with
// and without a flow. The sums over cells of 2 cm are off by the curvature of the profile alone.
TEST_CASE("scour keeps the volume of the bed") {
  for (const Shape& shape : {kBox, Shape(SphereShape{0.4}), Shape(CylinderShape{0.1, 0.7})}) {
    const Outline outline =
        moved(outline_of(shape, from_roll_pitch_yaw(radians(90), 0, radians(35))), {0.4, -0.2, 0});
    for (const bool flows : {false, true}) {
      ScourSpec spec{0.2, 0.6, 0.07, {}};
      if (flows) spec.direction_deg = 70;
      HeightGrid grid = flat_grid(501, 0.02);
      scour(spec, outline, {}, grid);
      double dug = 0, heaped = 0;
      for (const double h : grid.heights_m) (h < 0 ? dug : heaped) += h;
      CHECK(dug < -100);
      CHECK(std::abs(dug + heaped) < 1e-3 * heaped);
      const auto [low, high] = std::minmax_element(grid.heights_m.begin(), grid.heights_m.end());
      CHECK(*low == Approx(-0.2).epsilon(5e-3));
      CHECK(*high == Approx(0.07).epsilon(5e-3));
    }
  }
}

// Protects the profile on lines across the middles of a box's sides: nothing under the box, the
// depth half way through the pit, upstream alone where water flows, and the mound downstream.
TEST_CASE("the pit is deepest in its middle and upstream, the mound highest downstream") {
  const Outline outline = outline_of(kBox, {});
  HeightGrid round = flat_grid(601, 0.01), flow = round;
  scour({0.1, 0.4, {}, {}}, outline, {}, round);
  scour({0.1, 0.4, {}, 0}, outline, {}, flow);
  for (double x = -0.5; x <= 0.5; x += 0.05) {
    for (double y = -0.3; y <= 0.3; y += 0.05) {
      CHECK(height(round, x, y) == Approx(0).margin(1e-12));
      CHECK(height(flow, x, y) == Approx(0).margin(1e-12));
    }
  }
  CHECK(height(round, 0.7, 0) == Approx(-0.1));
  CHECK(height(round, 0, -0.5) == Approx(-0.1));
  CHECK(height(round, 0.6, 0) == Approx(-0.05));
  CHECK(height(round, 0.9, 0) == Approx(0).margin(1e-6));
  CHECK(height(flow, -0.7, 0) == Approx(-0.1));
  CHECK(height(flow, 0, 0.5) == Approx(-0.05));
  CHECK(height(flow, 0.7, 0) == Approx(0).margin(1e-12));
  const double mound_width = scour_shape({0.1, 0.4, {}, 0}, outline).mound_width_m;
  const double crest = 0.5 + 0.4 + mound_width / 2;
  CHECK(height(flow, crest, 0) == Approx(0.05).epsilon(1e-3));
  CHECK(height(flow, -crest, 0) == Approx(0).margin(1e-12));
  CHECK(height(flow, crest + mound_width / 2 + 0.02, 0) == 0);
}

// Protects other frames: around an object over turned, moved terrain the pit is where the object
// is.
TEST_CASE("scour follows the pose of the terrain") {
  const Pose pose{{5, -3, -8}, from_roll_pitch_yaw(0, 0, radians(90))};
  const Outline outline = moved(outline_of(Shape(SphereShape{0.5}), {}), {5.5, -2, -8});
  HeightGrid grid = flat_grid(301, 0.02);
  scour({0.1, 0.4, {}, 0}, outline, pose, grid);
  // World (5.5, -2) is (1, -0.5) in the terrain's frame, and upstream, -x, is +y there.
  CHECK(height(grid, 1, -0.5) == 0);
  CHECK(height(grid, 1, -0.5 + 0.7) == Approx(-0.1));
  CHECK(height(grid, 1 + 0.7, -0.5) == Approx(-0.05));
  HeightGrid tilted = flat_grid(301, 0.02);
  scour({0.1, 0.4, {}, 0}, outline_of(Shape(SphereShape{0.5}), {}),
        {{}, from_roll_pitch_yaw(0, radians(60), 0)}, tilted);
  CHECK(height(tilted, -1.4, 0) == Approx(-0.1));
}

namespace {

Scenario scene(const HeightfieldSpec& bed, std::optional<ScourSpec> scour) {
  Scenario scenario;
  scenario.seed = 4;
  scenario.materials = {{"m", 1, {}, {}}};
  ObjectSpec box{"box", "x", "m", BoxSpec{{0.8, 0.5, 0.4}}, {}};
  box.place = PlaceSpec{};
  box.place->on = "bed";
  box.place->area_m = {{{-2, -2}, {2, 2}}};
  box.place->scour = scour;
  scenario.objects = {{"bed", "x", "m", bed, {{1, 0, -4}, {}}}, box};
  return scenario;
}

}  // namespace

// Protects the order: the object stands where it stood without scour, and the bed under it is as it
// was; the mesh of the world and its box have the pit.
TEST_CASE("scour leaves the pose of the object and the bed under it") {
  HeightfieldSpec bed;
  bed.size_m = {10, 10};
  bed.cell_m = 0.05;
  bed.ripples = {{0.03, 0.5, 30}};
  bed.stones = {{1, {0.2, 0.5}, 3, {0.6, 1}, {0.4, 0.8}, {0.3, 0.7}, 6}};
  const auto plain = build_world(scene(bed, {}));
  const auto scoured = build_world(scene(bed, ScourSpec{0.3, 0.5, {}, 0}));
  REQUIRE(plain.ok());
  REQUIRE(scoured.ok());
  const Pose& pose = scoured->objects[1].pose;
  CHECK(pose.position_m.x == plain->objects[1].pose.position_m.x);
  CHECK(pose.position_m.z == plain->objects[1].pose.position_m.z);
  const Ground before(plain->objects[0].shape, plain->objects[0].pose);
  const Ground after(scoured->objects[0].shape, scoured->objects[0].pose);
  const auto change = [&](double along, double across) {
    const Vec3 p = transform_point(pose, {along, across, 0});
    return after.at(p.x, p.y)->height_m - before.at(p.x, p.y)->height_m;
  };
  CHECK(change(0.3, 0.2) == Approx(0).margin(1e-6));
  const double yaw =
      std::atan2(rotate(pose.rotation, {1, 0, 0}).y, rotate(pose.rotation, {1, 0, 0}).x);
  // The normal of the side looks along the object's own x, at the angle yaw to the flow.
  CHECK(change(0.4 + 0.25, 0) == Approx(-0.3 * (1 - std::cos(yaw)) / 2).margin(0.01));
  CHECK(change(-0.4 - 0.25, 0) == Approx(-0.3 * (1 + std::cos(yaw)) / 2).margin(0.01));
  const auto lowest = [](const World& world) {
    const OrientedBox& box = *world.instances[0].box;
    return box.pose.position_m.z - box.size_m.z / 2;
  };
  CHECK(lowest(*scoured) < lowest(*plain) - 0.2);
  CHECK(scoured->instances[0].vertex_reflectivity);
}
