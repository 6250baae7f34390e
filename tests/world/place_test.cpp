#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "is_refused.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/ground.h"
#include "world/outline.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

ObjectSpec placed(const std::string& name, ShapeSpec shape, PlaceSpec place) {
  ObjectSpec spec = object(name, std::move(shape));
  spec.place = std::move(place);
  return spec;
}

PlaceSpec on(const std::string& ground, double half_m) {
  PlaceSpec place;
  place.on = ground;
  place.area_m = {{{-half_m, -half_m}, {half_m, half_m}}};
  return place;
}

const Pose& pose_in(const World& world, const std::string& name) {
  return object_in(world, name).pose;
}

double lowest(const Shape& shape, const Pose& pose) {
  return pose.position_m.z + outline_of(shape, pose.rotation).low_m;
}

// A dome of 20 m x 20 m, z = -(x^2 + y^2) / 40, in steps of 0.25 m.
std::string dome_obj() {
  std::string text;
  constexpr int kSide = 81;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double x = -10 + 0.25 * i, y = -10 + 0.25 * j;
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " +
              std::to_string(-(x * x + y * y) / 40) + "\n";
    }
  }
  for (int j = 0; j + 1 < kSide; ++j) {
    for (int i = 0; i + 1 < kSide; ++i) {
      const int a = j * kSide + i + 1;
      const auto face = [&](int p, int q, int r) {
        text += "f " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(r) + "\n";
      };
      face(a, a + 1, a + kSide);
      face(a + 1, a + kSide + 1, a + kSide);
    }
  }
  return text;
}

}  // namespace

// Protects the ground that others stand on: heights of closed forms, turned and moved.
TEST_CASE("the ground under a point is that of its surface") {
  const Pose tilted{{1, 2, 3}, from_roll_pitch_yaw(0, radians(30), 0)};
  const Shape flat = PlaneShape{};
  const Ground plane(flat, tilted);
  const auto under = plane.at(3, 7);
  REQUIRE(under);
  CHECK(under->height_m == Approx(3 - 2 * std::tan(radians(30))).epsilon(1e-12));
  CHECK(under->normal.x == Approx(0.5));
  const Shape ball = SphereShape{2};
  CHECK(Ground(ball, {{0, 0, 5}, {}}).at(1, 0)->height_m == Approx(5 + std::sqrt(3)));
  CHECK_FALSE(Ground(ball, {{0, 0, 5}, {}}).at(2.01, 0));
  const Shape room = BoxShape{{5, 5, 2}, true};
  CHECK(Ground(room, {{0, 0, 1}, {}}).at(1, 1)->height_m == Approx(-1));
  const Shape upright = PlaneShape{};
  CHECK_FALSE(Ground(upright, {{}, from_roll_pitch_yaw(radians(90), 0, 0)}).at(0, 0));
}

// Protects the search through the grid: a mesh of a function, against that function's own triangles
// on every edge and between (a step of 0.05 m meets vertices, edges and diagonals).
TEST_CASE("the ground of a mesh has no cracks", "[figure]") {
  const TemporaryFolder folder;
  const auto mesh = load_mesh(folder.write("dome.obj", dome_obj()), {1, 1, 1}, Normals::face);
  REQUIRE(mesh.ok());
  const Shape shape = MeshShape{std::make_shared<const Mesh>(*mesh)};
  const Ground ground(shape, {});
  double worst = 0;
  for (int i = -200; i <= 200; ++i) {
    for (int j = -200; j <= 200; j += 3) {
      const double x = 0.05 * i, y = 0.05 * j;
      const auto under = ground.at(x, y);
      REQUIRE(under);
      worst = std::max(worst, std::abs(under->height_m + (x * x + y * y) / 40));
      if (i % 20 != 0) continue;
      const auto alone = ground_at(shape, {}, x, y);
      REQUIRE(alone);
      CHECK(alone->height_m == under->height_m);
    }
  }
  // A chord of 0.25 m (and the diagonal's) stays this near to the paraboloid.
  CHECK(worst < 0.25 * 0.25 / 8 / 20 * 2 + 2e-6);
  CHECK_FALSE(ground.at(10.1, 0));
  CHECK_FALSE(ground_at(shape, {}, 10.1, 0));
}

// Protects the circle that keeps objects apart: a lying cylinder's is around its corners.
TEST_CASE("outlines hold the whole of a turned body") {
  for (const double pitch : {0.0, 20.0, 60.0, 90.0}) {
    const Quat turn = from_roll_pitch_yaw(radians(15), radians(pitch), radians(40));
    for (const Shape& shape : std::vector<Shape>{BoxShape{{1, 2, 0.5}}, CylinderShape{0.5, 2},
                                                 CylinderShape{2, 0.1}, SphereShape{1.5}}) {
      const Outline outline = outline_of(shape, turn);
      double radius = 0, low = 0;
      for (const Vec3& point : contact_points(shape)) {
        const Vec3 p = rotate(turn, point);
        radius = std::max(radius, std::hypot(p.x, p.y));
        low = std::min(low, p.z);
      }
      CHECK(radius <= outline.radius_m + 1e-12);
      CHECK(radius > 0.98 * outline.radius_m);
      CHECK(low >= outline.low_m - 1e-12);
      CHECK(low < 0.98 * outline.low_m);
    }
  }
}

// Of points on their surfaces, seen from above.
double nearest_points_m(const WorldObject& a, const WorldObject& b) {
  double nearest = HUGE_VAL;
  for (const Vec3& p : contact_points(a.shape)) {
    const Vec3 from = a.pose.position_m + rotate(a.pose.rotation, p);
    for (const Vec3& q : contact_points(b.shape)) {
      const Vec3 to = b.pose.position_m + rotate(b.pose.rotation, q);
      nearest = std::min(nearest, std::hypot(from.x - to.x, from.y - to.y));
    }
  }
  return nearest;
}

// Protects against objects in each other: 60 of several shapes in every one of 20 sequences, the
// surfaces of each pair at least the clearance apart, beside a resting one as well.
TEST_CASE("placed objects keep their distance", "[figure]") {
  std::vector<ObjectSpec> objects = {object("floor", PlaneSpec{}),
                                     object("pile", CylinderSpec{1, 10})};
  PlaceSpec place = on("floor", 10);
  place.clearance_m = 0.1;
  for (int i = 0; i < 20; ++i) {
    const std::string n = std::to_string(i);
    objects.push_back(placed("ball" + n, SphereSpec{0.3}, place));
    objects.push_back(placed("box" + n, BoxSpec{{0.8, 0.4, 0.3}}, place));
    objects.push_back(placed("can" + n, CylinderSpec{0.2, 0.6}, place));
  }
  const Scenario scenario = scenario_of(objects);
  int near_pairs = 0;
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const World world = built(scenario, sequence);
    for (std::size_t i = 1; i < world.objects.size(); ++i) {
      const WorldObject& a = world.objects[i];
      for (std::size_t j = i + 1; j < world.objects.size(); ++j) {
        const WorldObject& b = world.objects[j];
        const Vec3 apart = a.pose.position_m - b.pose.position_m;
        if (std::hypot(apart.x, apart.y) > 1.5) continue;
        near_pairs += 1;
        REQUIRE(nearest_points_m(a, b) >= 0.1 - 1e-9);
      }
      if (i > 1) {
        REQUIRE(std::abs(lowest(a.shape, a.pose)) < 1e-9);
      }
    }
  }
  CHECK(near_pairs > 100);
}

// Protects room beside long bodies: a square post finds a place beside a beam of 8 m x 0.4 m within
// the circle around that beam.
TEST_CASE("a long body takes no more room than its outline") {
  PlaceSpec beside = on("floor", 1);
  beside.clearance_m = 0.05;
  const Scenario scenario =
      scenario_of({object("floor", PlaneSpec{}), object("beam", BoxSpec{{8, 0.4, 0.4}}, {{0, 0, 0.2}, {}}),
                   placed("post", BoxSpec{{0.3, 0.3, 1}}, beside)});
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    CHECK(std::abs(pose_in(built(scenario, sequence), "post").position_m.y) > 0.4);
  }
}

// Protects contact: of a ball and a box with the nearest other one there is no gap and no overlap.
TEST_CASE("a touching object meets the nearest one") {
  PlaceSpec touching = on("floor", 6);
  touching.touching = true;
  const Scenario scenario = scenario_of(
      {object("floor", PlaneSpec{}), placed("a", BoxSpec{{1, 2, 1}}, on("floor", 6)),
       placed("ball", SphereSpec{0.4}, touching), placed("box", BoxSpec{{0.5, 0.3, 0.2}}, touching)});
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const World world = built(scenario, sequence);
    const auto outline = [&](std::size_t i) {
      const WorldObject& of = world.objects[i];
      return moved(outline_of(of.shape, of.pose.rotation), of.pose.position_m);
    };
    CHECK(std::abs(gap_between(outline(1), outline(2)).distance_m) < 1e-8);
    const double to_a = gap_between(outline(3), outline(1)).distance_m;
    const double to_ball = gap_between(outline(3), outline(2)).distance_m;
    CHECK(std::abs(std::min(to_a, to_ball)) < 1e-8);
  }
}

// Protects the meaning of burial: by a share of the height, wherever the body's origin is.
TEST_CASE("a buried fraction lowers by a share of the height") {
  PlaceSpec buried = on("floor", 1);
  buried.buried_fraction = 0.25;
  buried.sink_m = 0.1;
  const World world = built(
      scenario_of({object("floor", PlaneSpec{}), placed("can", CylinderSpec{0.2, 0.8}, buried)}));
  CHECK(pose_in(world, "can").position_m.z == Approx(0.4 - 0.2 - 0.1));
}

// Protects rest: a flat box lies on one of its large faces about as often as their share of the solid
// angle says (300 sequences, three standard errors), and always flat on the ground.
TEST_CASE("a body at rest lies on a face") {
  PlaceSpec rest = on("floor", 3);
  rest.align = PlaceAlignment::rest;
  const BoxSpec slab{{1, 0.8, 0.2}};
  const Scenario scenario = scenario_of({object("floor", PlaneSpec{}), placed("a", slab, rest)});
  // Of a rectangle 2a x 2b at distance d: 4 atan(a b / (d sqrt(a^2 + b^2 + d^2))).
  const double a = 0.5, b = 0.4, d = 0.1;
  const double share = 2 * 4 * std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d))) / (4 * kPi);
  constexpr int kSequences = 300;
  double flat = 0;
  for (std::uint32_t sequence = 0; sequence < kSequences; ++sequence) {
    const Pose pose = pose_in(built(scenario, sequence), "a");
    double steepest = 0;
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      steepest = std::max(steepest, std::abs(rotate(pose.rotation, axis).z));
    }
    REQUIRE(steepest == Approx(1));
    flat += std::abs(rotate(pose.rotation, {0, 0, 1}).z) > 0.5;
  }
  CHECK(std::abs(flat / kSequences - share) < 3 * std::sqrt(share * (1 - share) / kSequences));
}

// Protects the area and the turn: uniform, mean and mean square within three standard errors
// (1000 sequences), never outside.
TEST_CASE("places are uniform over the area") {
  const Scenario scenario =
      scenario_of({object("floor", PlaneSpec{}), placed("a", BoxSpec{{1, 1, 1}}, on("floor", 3))});
  double x = 0, yy = 0, cosine = 0;
  for (std::uint32_t sequence = 0; sequence < 1000; ++sequence) {
    const Pose pose = pose_in(built(scenario, sequence), "a");
    REQUIRE(std::abs(pose.position_m.x) < 3);
    REQUIRE(std::abs(pose.position_m.y) < 3);
    x += pose.position_m.x / 1000;
    yy += pose.position_m.y * pose.position_m.y / 1000;
    cosine += rotate(pose.rotation, {1, 0, 0}).x / 1000;
  }
  CHECK(std::abs(x) < 3 * std::sqrt(3 / 1000.0));
  CHECK(std::abs(yy - 3) < 3 * std::sqrt((81.0 / 5 - 9) / 1000));
  CHECK(std::abs(cosine) < 3 * std::sqrt(0.5 / 1000));
}

// Protects standing: on a tilted box, aligned with it, the whole base lies on its face; upright, a
// ball and a box touch it and nothing sinks in (both from the plane's equation).
TEST_CASE("objects stand on a tilted box") {
  const PoseSpec tilt{{0, 0, -2}, std::array<double, 3>{20, 10, 30}};
  PlaceSpec up = on("ramp", 4), along = on("ramp", 4);
  along.align = PlaceAlignment::surface;
  along.sink_m = 0.05;
  const Scenario scenario = scenario_of(
      {object("ramp", BoxSpec{{20, 20, 2}}, tilt), placed("flat", BoxSpec{{1, 0.6, 0.4}}, along),
       placed("can", CylinderSpec{0.3, 1}, up), placed("ball", SphereSpec{0.4}, up)});
  const Pose ramp = pose_of(tilt);
  const Vec3 normal = rotate(ramp.rotation, {0, 0, 1});
  const auto over = [&](Vec3 p) { return dot(normal, p - ramp.position_m) - 1; };
  for (std::uint32_t sequence = 0; sequence < 50; ++sequence) {
    const World world = built(scenario, sequence);
    const Pose& flat = pose_in(world, "flat");
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.3, 0.3}) {
        CHECK(std::abs(over(transform_point(flat, {x, y, -0.2})) + 0.05 * normal.z) < 1e-6);
      }
    }
    CHECK(std::abs(over(pose_in(world, "ball").position_m) - 0.4) < 1e-6);
    const Pose& can = pose_in(world, "can");
    CHECK(rotate(can.rotation, {0, 0, 1}).z == Approx(1).epsilon(1e-12));
    const double level = std::hypot(normal.x, normal.y);
    CHECK(std::abs(over(can.position_m) - 0.5 * normal.z - 0.3 * level) < 1e-6);
  }
}

// Protects standing on terrain: nothing of a box is under the dome and something touches it; the
// lowest of these gaps is found here over a fine grid of its base. Along the surface the box leans
// outwards like the dome under its middle.
TEST_CASE("objects stand on a mesh") {
  const TemporaryFolder folder;
  const auto file = folder.write("dome.obj", dome_obj());
  PlaceSpec up = on("dome", 6), along = on("dome", 6);
  along.align = PlaceAlignment::surface;
  const Scenario scenario =
      scenario_of({object("dome", MeshSpec{file}), placed("up", BoxSpec{{1, 1, 1}}, up),
                   placed("along", BoxSpec{{0.5, 0.5, 0.2}}, along)});
  for (std::uint32_t sequence = 0; sequence < 8; ++sequence) {
    const World world = built(scenario, sequence);
    const Ground ground(world.objects[0].shape, {});
    const Pose& pose = pose_in(world, "up");
    double gap = 1;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -2; j <= 2; ++j) {
        const Vec3 p = transform_point(pose, {0.25 * i, 0.25 * j, -0.5});
        gap = std::min(gap, p.z - ground.at(p.x, p.y)->height_m);
      }
    }
    CHECK(std::abs(gap) < 1e-6);
    const Pose& leaning = pose_in(world, "along");
    const Vec3 axis = rotate(leaning.rotation, {0, 0, 1});
    const Vec3 p = leaning.position_m;
    const Vec3 normal = normalized(Vec3{p.x / 20, p.y / 20, 1});
    CHECK(dot(axis, normal) > std::cos(radians(1)));
  }
}

// Protects a scene under construction: objects that are not in the way change no place, wherever
// they stand in the list; another sequence or name does.
TEST_CASE("places do not depend on unrelated objects") {
  const std::vector<ObjectSpec> needed = {object("floor", PlaneSpec{}),
                                          placed("a", SphereSpec{0.3}, on("floor", 3)),
                                          placed("b", SphereSpec{0.3}, on("floor", 3))};
  std::vector<ObjectSpec> more = needed;
  more.insert(more.begin(), object("far", BoxSpec{{1, 1, 1}}, {{50, 0, 0}, {}}));
  more.insert(more.begin() + 2, object("above", BoxSpec{{9, 9, 1}}, {{0, 0, 8}, {}}));
  more.push_back(placed("c", SphereSpec{0.3}, on("floor", 3)));
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    const World alone = built(scenario_of(needed), sequence);
    const World beside = built(scenario_of(more), sequence);
    CHECK(pose_in(alone, "a") == pose_in(beside, "a"));
    CHECK(pose_in(alone, "b") == pose_in(beside, "b"));
    CHECK_FALSE(pose_in(alone, "a") == pose_in(built(scenario_of(needed), sequence + 1), "a"));
    CHECK_FALSE(pose_in(alone, "a").position_m == pose_in(alone, "b").position_m);
  }
}

// Protects a stack: what stands on a table avoids neither the floor nor the room around it.
TEST_CASE("an object may stand on a placed one") {
  const Scenario scenario = scenario_of({object("room", BoxSpec{{30, 30, 10}, true}),
                                         object("slab", BoxSpec{{20, 20, 1}}),
                                         placed("table", BoxSpec{{2, 2, 1}}, on("slab", 1)),
                                         placed("cup", CylinderSpec{0.1, 0.2}, on("table", 2))});
  const World world = built(scenario);
  CHECK(pose_in(world, "table").position_m.z == Approx(1));
  CHECK(pose_in(world, "cup").position_m.z == Approx(1.6));
}

// Protects against a placement that is given up silently.
TEST_CASE("too little room is told with the object and what to change") {
  std::vector<ObjectSpec> objects = {object("floor", PlaneSpec{})};
  for (int i = 0; i < 20; ++i) {
    objects.push_back(placed("ball" + std::to_string(i), SphereSpec{0.5}, on("floor", 1)));
  }
  const auto crowded = build_world(scenario_of(objects));
  CHECK(is_refused(crowded, ".place: found no free place for ball", ErrorKind::redraw));
  CHECK(is_refused(crowded, "too close to another object, most often ball"));
  const auto beside = build_world(scenario_of({object("slab", BoxSpec{{1, 1, 1}}, {{50, 0, 0}, {}}),
                                               placed("ball", SphereSpec{0.5}, on("slab", 1))}));
  CHECK(is_refused(beside, "200 times not entirely above slab"));
  const auto plane = build_world(
      scenario_of({object("floor", PlaneSpec{}), placed("p", PlaneSpec{}, on("floor", 1))}));
  CHECK(is_refused(plane, "infinite plane"));
}
