#include "world/outline.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

void check_close(Vec3 found, Vec3 expected) {
  CHECK(length(found - expected) < 1e-6 * (1 + length(expected)));
}

}  // namespace

// Protects the sizes that 3-D detectors train on: full lengths, not halves.
TEST_CASE("closed forms have boxes of their full size, planes none") {
  const auto box = box_of(Shape(BoxShape{{1, 2, 3}, true}));
  REQUIRE(box);
  check_close(box->size_m, {2, 4, 6});
  check_close(box->pose.position_m, {0, 0, 0});
  check_close(box_of(Shape(SphereShape{0.5}))->size_m, {1, 1, 1});
  check_close(box_of(Shape(CylinderShape{0.5, 2}))->size_m, {1, 1, 4});
  CHECK_FALSE(box_of(Shape(PlaneShape{})));
}

// Protects meshes that do not stand around their origin.
TEST_CASE("a mesh's box is around its vertices, wherever they are") {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{1, 0, -2}, {3, 5, -2}, {2, 1, 4}};
  const auto box = box_of(Shape(MeshShape{mesh}));
  REQUIRE(box);
  check_close(box->pose.position_m, {2, 2.5, 1});
  check_close(box->size_m, {2, 5, 6});
}

// Protects volumes: their boxes stand in the world, since they have no row in objects.csv.
TEST_CASE("volumes have boxes in the world, water without end none") {
  Volume volume;
  volume.density = DensityBox{{1, 2, 3}};
  volume.pose = {{10, 0, -5}, from_roll_pitch_yaw(0, 0, kPi / 2)};
  const auto box = box_of(volume);
  REQUIRE(box);
  check_close(box->size_m, {2, 4, 6});
  CHECK(box->pose == volume.pose);
  volume.density = DensityEverywhere{};
  CHECK_FALSE(box_of(volume));

  School school;
  CHECK_FALSE(box_of(school));
  school.fish_m = {{1, 1, 1}, {3, 0, 1}};
  check_close(box_of(school)->size_m, {2, 1, 0});
  check_close(box_of(school)->pose.position_m, {2, 0.5, 1});
}

// Protects the inverse of the grid's map, scale, turn and shift: one brick at a known place.
TEST_CASE("a grid's box is around its bricks that hold something") {
  auto grid = std::make_shared<DensityGrid>();
  // Index 0 lies at (5, 0, 0) of the volume's frame; half a metre between samples; index x runs
  // along the frame's y, index y against its x.
  grid->index_from_local.rows = {Vec3{0, 2, 0}, Vec3{-2, 0, 0}, Vec3{0, 0, 2}};
  grid->index_from_local.offset = {0, 10, 0};
  grid->bricks = {2, 1, 1};
  grid->top = {-1, 0};
  Volume volume;
  volume.density = std::shared_ptr<const DensityGrid>(grid);
  const auto box = box_of(volume);
  REQUIRE(box);
  // Indices x 8 ... 16, y 0 ... 8, z 0 ... 8.
  check_close(box->pose.position_m, {3, 6, 2});
  check_close(box->size_m, {4, 4, 4});
  grid->top = {-1, -1};
  CHECK_FALSE(box_of(volume));
}
