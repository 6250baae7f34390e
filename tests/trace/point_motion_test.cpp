// Points of one ping in another, where geometry gives the answer.
#include "trace/echo_points.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "core/units.h"
#include "trace/plain_world.h"
#include "trace/scene.h"

using namespace ensonify;

namespace {

constexpr double kSample_m = 0.05;

Sonar fan_of_60_degrees() {
  Sonar sonar;
  sonar.beam_count = 60;
  sonar.beam_spacing_rad = radians(1);
  sonar.range_min_m = 0.5;
  sonar.range_max_m = 20;
  sonar.elevation_fan_rad = radians(60);
  return sonar;
}

Scatterer point_at(const Pose& sonar, Vec3 in_world, std::uint32_t instance) {
  Scatterer s;
  s.position_m = inverse_transform_point(sonar, in_world);
  s.instance = instance;
  return s;
}

struct MovedScene {
  World world;
  Pose sonar_here, sonar_there;
  std::vector<Pose> objects_there;

  PointMotion of(Vec3 in_world, std::uint32_t instance) const {
    const std::vector<Pose> here = own_poses(world);
    const Tracer tracer = Tracer(world).at(objects_there);
    const Sonar sonar = fan_of_60_degrees();
    const PointMover mover{
        world, sonar_here, here, objects_there, {tracer, sonar, sonar_there}, kSample_m};
    ScattererList list;
    list.items = {point_at(sonar_here, in_world, instance)};
    PointMotion motion;
    const std::uint32_t which = 0;
    point_motions(mover, list, {&which, 1}, {&motion, 1});
    return motion;
  }
};

}  // namespace

// Protects the signs: a sonar that turns to port by 3 degrees sees the world 3 beams to starboard.
TEST_CASE("a turn about z moves resting points by beams alone") {
  MovedScene scene{world_of({{PlaneShape{}, {{0, 0, -2}, {}}}}), {}, {}, {{{0, 0, -2}, {}}}};
  scene.sonar_here = {{1, 2, 0}, from_roll_pitch_yaw(0, 0, 0.2)};
  scene.sonar_there = {{1, 2, 0}, from_roll_pitch_yaw(0, 0, 0.2 + radians(3))};
  const Vec3 point{1 + 6 * std::cos(0.3), 2 + 6 * std::sin(0.3), -2};
  const PointMotion motion = scene.of(point, 1);
  CHECK(motion.sample == Approx(std::hypot(6, 2) / kSample_m));
  CHECK(motion.beam == Approx(29.5 + degrees(0.1)));
  CHECK(motion.sample_there - motion.sample == Approx(0).margin(1e-9));
  CHECK(motion.beam_there - motion.beam == Approx(-3));
  CHECK(motion.state == PointState::seen);
}

// Protects places: ahead by 1 m, the point of a plane below is nearer by the difference of two
// hypotenuses.
TEST_CASE("a step ahead moves a point of the floor by its own range") {
  MovedScene scene{world_of({{PlaneShape{}, {{0, 0, -3}, {}}}}), {}, {}, {{{0, 0, -3}, {}}}};
  scene.sonar_there = {{1, 0, 0}, {}};
  const PointMotion motion = scene.of({8, 1, -3}, 1);
  const double here_m = std::sqrt(64.0 + 1 + 9), there_m = std::sqrt(49.0 + 1 + 9);
  CHECK(motion.sample_there - motion.sample == Approx((there_m - here_m) / kSample_m));
  CHECK(motion.beam_there - motion.beam ==
        Approx(degrees(std::atan2(1, 7) - std::atan2(1, 8))));
  CHECK(motion.state == PointState::seen);
  CHECK(scene.of({0.9, 0, -3}, 1).state == PointState::outside);  // below the elevation fan there
}

// Protects moving objects: a point of a box goes along with it, and turns with it.
TEST_CASE("points move with their objects and are hidden by others and by their own") {
  const Pose box_here{{6, 0, 0}, {}}, wall{{4, 1.8, 0}, {}};
  const World world =
      world_of({{BoxShape{{0.5, 0.5, 0.5}}, box_here}, {BoxShape{{0.1, 1, 1}}, wall}});
  const Vec3 front{5.5, 0.2, 0.1};
  SECTION("to port behind the wall") {
    const MovedScene scene{world, {}, {}, {{{6, 2.2, 0}, {}}, wall}};
    const PointMotion motion = scene.of(front, 1);
    CHECK(motion.beam_there == Approx(29.5 + degrees(std::atan2(2.4, 5.5))).margin(1e-9));
    CHECK(motion.sample_there == Approx(length(Vec3{5.5, 2.4, 0.1}) / kSample_m));
    CHECK(motion.state == PointState::hidden);
    CHECK(motion.occluder == 2);
  }
  SECTION("half a turn about itself") {
    const MovedScene scene{world, {}, {}, {{{6, 0, 0}, from_roll_pitch_yaw(0, 0, kPi)}, wall}};
    const PointMotion motion = scene.of(front, 1);
    CHECK(motion.sample_there == Approx(length(Vec3{6.5, -0.2, 0.1}) / kSample_m));
    CHECK(motion.state == PointState::hidden);
    CHECK(motion.occluder == 1);
  }
  SECTION("out of the fan, and out of range") {
    const MovedScene scene{world, {}, {}, {{{6, 20, 0}, {}}, wall}};
    CHECK(scene.of(front, 1).state == PointState::outside);
    const MovedScene far{world, {}, {{-30, 0, 0}, {}}, {box_here, wall}};
    CHECK(far.of(front, 1).state == PointState::outside);
  }
}

// Protects elastic bodies, whose echoes come from inside their own surface.
TEST_CASE("a body that rings does not hide its own center") {
  MovedScene scene{world_of({{SphereShape{0.4}, {{6, 0, 0}, {}}}, {BoxShape{{0.1, 1, 1}}, {{3, 3, 0}, {}}}}),
                   {},
                   {{0, 0.5, 0}, {}},
                   {{{6, 0, 0}, {}}, {{3, 3, 0}, {}}}};
  CHECK(scene.of({6, 0, 0}, 1).occluder == 1);
  scene.world.objects[0].ringing.taps.resize(1);
  CHECK(scene.of({6, 0, 0}, 1).state == PointState::seen);
  scene.objects_there[1].position_m = {3, 0.2, 0};
  CHECK(scene.of({6, 0, 0}, 1).occluder == 2);
}

TEST_CASE("point targets rest and volumes have no points") {
  MovedScene scene{world_of({{BoxShape{{0.5, 0.5, 0.5}}, {{9, 0, 0}, {}}}}),
                   {},
                   {{0, 1, 0}, {}},
                   {{{9, 0, 0}, {}}}};
  scene.world.point_targets.resize(1);
  const PointMotion target = scene.of({5, 0, 0}, 2);
  CHECK(target.state == PointState::seen);
  CHECK(target.beam_there - target.beam == Approx(-degrees(std::atan2(1, 5))));
  const PointMotion water = scene.of({5, 0, 0}, 3);
  CHECK(water.state == PointState::none);
  CHECK(std::isnan(water.sample));
}
