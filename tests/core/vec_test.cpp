#include "core/vec.h"

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

void check_near(Vec3 a, Vec3 b) { CHECK(length(a - b) < 1e-12); }

}  // namespace

// Protects the frames: yaw turns to port, positive pitch is nose down, roll leans to starboard.
TEST_CASE("roll, pitch and yaw follow the ROS convention") {
  check_near(rotate(from_roll_pitch_yaw(0, 0, radians(90)), {1, 0, 0}), {0, 1, 0});
  check_near(rotate(from_roll_pitch_yaw(0, radians(90), 0), {1, 0, 0}), {0, 0, -1});
  check_near(rotate(from_roll_pitch_yaw(radians(90), 0, 0), {0, 1, 0}), {0, 0, 1});
  // Intrinsic z-y'-x'': the pitch is about the yawed axis.
  const Quat q = from_roll_pitch_yaw(radians(10), radians(20), radians(30));
  const Quat step = from_roll_pitch_yaw(0, 0, radians(30)) *
                    from_roll_pitch_yaw(0, radians(20), 0) * from_roll_pitch_yaw(radians(10), 0, 0);
  check_near(rotate(q, {1, 2, 3}), rotate(step, {1, 2, 3}));
}

TEST_CASE("poses compose and invert") {
  const Pose body{{1, 2, 3}, from_roll_pitch_yaw(0.1, 0.2, 0.3)};
  const Pose mount{{0.5, 0, -0.2}, from_roll_pitch_yaw(0, 0.5, 0)};
  const Vec3 p{4, -5, 6};
  check_near(transform_point(compose(body, mount), p),
             transform_point(body, transform_point(mount, p)));
  check_near(inverse_transform_point(body, transform_point(body, p)), p);
}

// Protects trajectories: half the way is half the angle, by the shorter arc, and equal ends do not
// divide by zero.
TEST_CASE("slerp takes the shorter arc") {
  const Quat a;
  const Quat b = from_roll_pitch_yaw(0, 0, radians(80));
  check_near(rotate(slerp(a, b, 0.5), {1, 0, 0}),
             rotate(from_roll_pitch_yaw(0, 0, radians(40)), {1, 0, 0}));
  const Quat same{-b.w, -b.x, -b.y, -b.z};
  check_near(rotate(slerp(a, same, 0.25), {1, 0, 0}),
             rotate(from_roll_pitch_yaw(0, 0, radians(20)), {1, 0, 0}));
  check_near(rotate(slerp(b, b, 0.3), {1, 0, 0}), rotate(b, {1, 0, 0}));
}
