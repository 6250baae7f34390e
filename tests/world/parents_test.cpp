// Objects whose poses are in the frames of others.
#include <algorithm>
#include <cmath>
#include <string>

#include "catch.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "world/outline.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

World family(const std::string& objects, std::uint32_t sequence = 0) {
  return built(scenario_of_text(3, objects, sequence), sequence);
}

double apart(const Pose& a, const Pose& b) {
  double worst = length(a.position_m - b.position_m);
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    worst = std::max(worst, length(rotate(a.rotation, axis) - rotate(b.rotation, axis)));
  }
  return worst;
}

const std::string kBall = "material: m, shape: {sphere: {radius_m: 0.2}}";

}  // namespace

// The composed pose of a chain, by hand: a yaw of 90 degrees turns x to y, a half turn about x
// turns z over. The child may stand before its parent.
TEST_CASE("poses of a chain of parents are composed") {
  const World world = family(
      "  - {name: c, " + kBall +
      ", pose: {parent: b, position_m: [0, 0, 2]}}\n"
      "  - {name: a, " +
      kBall +
      ", pose: {position_m: [5, 1, -3], rotation_deg: [0, 0, 90]}}\n"
      "  - {name: b, " +
      kBall + ", pose: {parent: a, position_m: [1, 0, 1], quaternion_wxyz: [0, 1, 0, 0]}}\n");
  const Pose b{{5, 2, -2}, from_roll_pitch_yaw(0, 0, radians(90)) * Quat{0, 1, 0, 0}};
  CHECK(apart(object_in(world, "b").pose, b) < 1e-14);
  CHECK(apart(object_in(world, "c").pose, {{5, 2, -4}, b.rotation}) < 1e-14);
  CHECK(object_in(world, "c").path == nullptr);
}

// A world with a parent is the world with the composed pose, to the last bit where the numbers are
// sums of powers of two.
TEST_CASE("a parent at rest leaves no trace") {
  const std::string parent = "  - {name: a, " + kBall +
                             ", pose: {position_m: [4, 0.5, -1], quaternion_wxyz: [0, 0, 0, 1]}}\n";
  const World by_parent =
      family(parent + "  - {name: b, " + kBall +
             ", pose: {parent: a, position_m: [1.25, -2, 0.5], quaternion_wxyz: "
             "[0, 1, 0, 0]}}\n");
  const World composed =
      family(parent + "  - {name: b, " + kBall +
             ", pose: {position_m: [2.75, 2.5, -0.5], quaternion_wxyz: [0, 0, 1, 0]}}\n");
  CHECK(object_in(by_parent, "b").pose == object_in(composed, "b").pose);
}

// Protects ropes on buoys: at every time the point of the child in its carrier is the same, with
// wave motion too, and through a chain.
TEST_CASE("children move with their parents") {
  const World world =
      family("  - {name: buoy, " + kBall +
             ", trajectory: {orbit: {center_m: [0, 0, 0], radius_m: 3, speed_m_s: 1}, wave_motion: "
             "{roll_deg: 5, heave_m: 0.2, period_s: 4}}}\n"
             "  - {name: rope, " +
             kBall +
             ", pose: {parent: buoy, position_m: [0, 0, -1], rotation_deg: [0, 30, 0]}}\n"
             "  - {name: weight, " +
             kBall + ", pose: {parent: rope, position_m: [0, 0, -2]}}\n");
  const WorldObject& buoy = object_in(world, "buoy");
  const WorldObject& weight = object_in(world, "weight");
  const double pitch = radians(30);
  const Vec3 hangs{-2 * std::sin(pitch), 0, -1 - 2 * std::cos(pitch)};
  Vec3 first{};
  for (const double time : {-1.0, 0.0, 0.7, 5.0, 18.0, 30.0}) {
    const Pose carrier = object_pose(buoy, time);
    const Pose carried = object_pose(weight, time);
    CHECK(length(carried.position_m - transform_point(carrier, hangs)) < 1e-13);
    if (time == 0.0) first = carried.position_m;
    if (time == 5.0) CHECK(length(carried.position_m - first) > 1);
  }
  CHECK(weight.pose == object_pose(weight, 0));
  CHECK(span_of(*weight.path).end_s == span_of(*buoy.path).end_s);
}

// Protects room: a mast beside its placed parent keeps others away, those at rest before it and
// those placed after it; a parent that has room is where it is without children.
TEST_CASE("children of placed objects stand free as well") {
  const std::string floor = "  - {name: floor, material: m, shape: {plane: {}}}\n";
  const std::string parent =
      "  - {name: base, " + kBall +
      ", place: {on: floor, area_m: [[-2, -2], [2, 2]], clearance_m: 0.1}}\n";
  const std::string mast =
      "  - {name: mast, material: m, shape: {box: {size_m: [2, 0.1, 0.1]}}, pose: {parent: base, "
      "position_m: [1.1, 0, 0]}}\n";
  const std::string post =
      "  - {name: post, material: m, shape: {cylinder: {radius_m: 0.9, height_m: 4}}, pose: "
      "{position_m: [0, 0, 0]}}\n";
  const std::string later = "  - {name: later, " + kBall +
                            ", place: {on: floor, area_m: [[-2, -2], [2, 2]], clearance_m: 0.1}}\n";
  const auto outline = [](const WorldObject& o) {
    return moved(outline_of(o.shape, o.pose.rotation), o.pose.position_m);
  };
  int moved_by_mast = 0;
  for (std::uint32_t sequence = 0; sequence < 60; ++sequence) {
    const World world = family(floor + post + parent + mast + later, sequence);
    const WorldObject& base = object_in(world, "base");
    const WorldObject& arm = object_in(world, "mast");
    CHECK(apart(arm.pose, compose(base.pose, {{1.1, 0, 0}, {}})) < 1e-14);
    CHECK(gap_between(outline(arm), outline(object_in(world, "post"))).distance_m >= 0.1 - 1e-9);
    CHECK(gap_between(outline(arm), outline(object_in(world, "later"))).distance_m >= 0.1 - 1e-9);
    // Where the first free place of the base has no room for the mast, and only there, it moved on.
    const World alone = family(floor + post + parent + later, sequence);
    const Pose first = object_in(alone, "base").pose;
    WorldObject there = arm;
    there.pose = compose(first, {{1.1, 0, 0}, {}});
    const bool has_room =
        gap_between(outline(there), outline(object_in(world, "post"))).distance_m >= 0.1;
    CHECK((base.pose == first) == has_room);
    moved_by_mast += has_room ? 0 : 1;
    const World free = family(floor + parent + mast, sequence);
    CHECK(object_in(free, "base").pose == object_in(family(floor + parent, sequence), "base").pose);
  }
  CHECK(moved_by_mast > 3);
  CHECK(moved_by_mast < 57);
}

TEST_CASE("children leave with an object that has no room") {
  const World world = family(
      "  - {name: floor, material: m, shape: {plane: {}}}\n"
      "  - {name: post, material: m, shape: {cylinder: {radius_m: 3, height_m: 4}}}\n"
      "  - {name: base, " +
      kBall +
      ", place: {on: floor, area_m: [[-1, -1], [1, 1]], on_failure: skip_object}}\n"
      "  - {name: mast, " +
      kBall +
      ", pose: {parent: base, position_m: [0, 0, 1]}}\n"
      "  - {name: last, " +
      kBall + "}\n");
  CHECK(world.left_out == std::vector<std::string>{"base", "mast"});
  CHECK(std::ranges::none_of(world.objects, [&](const WorldObject& o) {
    return world.instances[o.instance - 1].name == "mast";
  }));
  CHECK(object_in(world, "last").instance == 3);
}

// A table whose plate is a child of its leg: what stands on the plate is as high.
TEST_CASE("an object may stand on a child of a placed one") {
  const World world = family(
      "  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -4]}}\n"
      "  - {name: leg, material: m, shape: {cylinder: {radius_m: 0.1, height_m: 1}}, place: {on: "
      "floor, area_m: [[2, 2], [6, 6]]}}\n"
      "  - {name: plate, material: m, shape: {box: {size_m: [9, 9, 0.2]}}, pose: {parent: leg, "
      "position_m: [0, 0, 0.6]}}\n"
      "  - {name: cup, " +
      kBall + ", place: {on: plate, area_m: [[3.5, 3.5], [4.5, 4.5]]}}\n");
  CHECK(object_in(world, "cup").pose.position_m.z == Approx(-4 + 1 + 0.2 + 0.2).epsilon(1e-12));
}
