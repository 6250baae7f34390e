#include "world/path.h"

#include <cmath>
#include <complex>
#include <functional>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "world/world.h"

using namespace ensonify;

namespace {

WaveMotionSpec swell() {
  WaveMotionSpec spec;
  spec.roll_deg = 3;
  spec.pitch_deg = 2;
  spec.yaw_deg = 1;
  spec.heave_m = 0.25;
  spec.period_s = 8;
  spec.bandwidth = 0.2;
  return spec;
}

struct Angles {
  double roll, pitch, yaw;
};

// The inverse of from_roll_pitch_yaw, from the rotated axes.
Angles angles_of(Quat q) {
  const Vec3 x = rotate(q, {1, 0, 0}), y = rotate(q, {0, 1, 0}), z = rotate(q, {0, 0, 1});
  return {std::atan2(y.z, z.z), std::atan2(-x.z, std::hypot(x.x, x.y)), std::atan2(x.y, x.x)};
}

}  // namespace

// Protects "rms exact in the limit": over 2000 periods each key's own rms is the one asked for.
// Cross terms of two frequencies f apart average to 1 / (pi f T); neighbours are on average
// 0.2 * 6 / 32 / 8 Hz apart, which leaves 1e-2 of the mean square and half of it of the rms.
TEST_CASE("the rms over time is the one asked for") {
  const WaveMotion motion = make_wave_motion(swell(), 42, 0);
  double roll = 0, pitch = 0, yaw = 0, heave = 0;
  const int samples = 40000;
  for (int i = 0; i < samples; ++i) {
    const Pose pose = moved_by_waves(motion, 0.4 * i, {});
    const Angles angles = angles_of(pose.rotation);
    roll += angles.roll * angles.roll;
    pitch += angles.pitch * angles.pitch;
    yaw += angles.yaw * angles.yaw;
    heave += pose.position_m.z * pose.position_m.z;
  }
  CHECK(degrees(std::sqrt(roll / samples)) == Approx(3).epsilon(0.02));
  CHECK(degrees(std::sqrt(pitch / samples)) == Approx(2).epsilon(0.02));
  CHECK(degrees(std::sqrt(yaw / samples)) == Approx(1).epsilon(0.02));
  CHECK(std::sqrt(heave / samples) == Approx(0.25).epsilon(0.02));
}

// Protects the ensemble at one instant: 10,000 keys, the mean within 3 standard errors (0.01 rms),
// the variance too (relative error sqrt(2 / n) = 0.014), the fourth cumulant that of a sum of 32
// sinusoids, -1.5 / 32, standard error sqrt(24 / n) = 0.049; axes are independent.
TEST_CASE("over many keys an instant is nearly normal") {
  const int keys = 10000;
  double mean = 0, square = 0, fourth = 0, cross_term = 0;
  for (int k = 0; k < keys; ++k) {
    const auto key = stream_key(5, Stream::motion, static_cast<std::uint32_t>(k));
    const Pose pose = moved_by_waves(make_wave_motion(swell(), key, 0), 12.3, {});
    const double heave = pose.position_m.z / 0.25;
    mean += heave;
    square += heave * heave;
    fourth += std::pow(heave, 4);
    cross_term += heave * angles_of(pose.rotation).roll / radians(3);
  }
  CHECK(std::abs(mean / keys) < 0.03);
  CHECK(square / keys == Approx(1).margin(0.0425));
  CHECK(fourth / keys - 3 * std::pow(square / keys, 2) == Approx(-1.5 / 32).margin(0.147));
  CHECK(std::abs(cross_term / keys) < 0.03);
}

// Protects the spectrum: the autocorrelation over keys is the transform of the density asked for,
// cos(2 pi tau / T) exp(-(2 pi b tau / T)^2 / 2), in which the cut at three standard deviations
// leaves less than 0.01. 8000 keys; a product of two normal variables has a standard error of at
// most sqrt(2 / n) = 0.016.
TEST_CASE("the spectrum has the period and the width asked for") {
  const int keys = 8000;
  const double lags[] = {0, 1, 2, 4, 6, 8, 12, 16, 24, 40};
  double sums[10] = {};
  WaveMotionSpec spec;
  spec.heave_m = 0.25;
  spec.period_s = 8;
  for (int k = 0; k < keys; ++k) {
    const WaveMotion motion = make_wave_motion(spec, mix64(static_cast<std::uint64_t>(k)), 0);
    const auto heave = [&](double t) { return moved_by_waves(motion, t, {}).position_m.z / 0.25; };
    const double first = heave(3);
    for (int i = 0; i < 10; ++i) sums[i] += first * heave(3 + lags[i]);
  }
  for (int i = 0; i < 10; ++i) {
    const double turn = 2 * kPi * lags[i] / 8;
    INFO("lag " << lags[i] << " s");
    CHECK(sums[i] / keys ==
          Approx(std::cos(turn) * std::exp(-0.5 * std::pow(0.2 * turn, 2))).margin(0.048 + 0.01));
  }
}

// Protects every frequency: the drawn ones themselves against the density's moments. 500 keys of
// 32 strata: the standard error of the mean is under 0.2 / sqrt(16000) = 0.0016 of the peak. A
// normal density cut at three standard deviations keeps 0.98658 of its spread.
TEST_CASE("frequencies are drawn from the density") {
  double mean = 0, square = 0, least = 1e9, most = 0;
  const int keys = 500, count = keys * WaveMotion::kTerms;
  for (int k = 0; k < keys; ++k) {
    const WaveMotion motion = make_wave_motion(swell(), mix64(static_cast<std::uint64_t>(k)), 0);
    for (const WaveMotion::Sinusoid& term : motion.pitch.terms) {
      const double relative = term.rad_s * 8 / (2 * kPi);
      mean += relative;
      square += (relative - 1) * (relative - 1);
      least = std::min(least, relative);
      most = std::max(most, relative);
    }
  }
  CHECK(mean / count == Approx(1).margin(0.005));
  CHECK(std::sqrt(square / count) == Approx(0.2 * 0.98658).epsilon(0.02));
  CHECK(least > 1 - 0.6);
  CHECK(most < 1 + 0.6);
}

// Protects the frames: attitude in the body's, after its own; heave along the world's z even for a
// body that hangs on its side; nothing else moves.
TEST_CASE("wave motion turns the body about itself and heaves it upright") {
  const Pose body{{1, 2, 3}, from_roll_pitch_yaw(1.2, -0.4, 2.5)};
  const WaveMotion motion = make_wave_motion(swell(), 9, 100);
  const Pose bare = moved_by_waves(motion, 107, {}), moved = moved_by_waves(motion, 107, body);
  CHECK(length(moved.position_m - body.position_m - bare.position_m) < 1e-15);
  CHECK(bare.position_m.x == 0);
  CHECK(bare.position_m.y == 0);
  CHECK(bare.position_m.z != 0);
  for (const Vec3 v : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
    CHECK(length(rotate(moved.rotation, v) - rotate(body.rotation, rotate(bare.rotation, v))) <
          1e-12);
  }
}

TEST_CASE("an axis without rms is left alone") {
  WaveMotionSpec spec;
  spec.yaw_deg = 4;
  spec.period_s = 3;
  const Pose pose = moved_by_waves(make_wave_motion(spec, 1, 0), 5, {});
  CHECK(pose.position_m == Vec3{});
  CHECK(pose.rotation.x == 0);
  CHECK(pose.rotation.y == 0);
  CHECK(pose.rotation.z != 0);
}

namespace {

Scenario with_movers(const std::vector<std::string>& names) {
  Scenario scenario;
  scenario.seed = 6;
  scenario.materials = {{"steel", 0.01, {}, {}}};
  for (const std::string& name : names) {
    ObjectSpec object{name, "thing", "steel", SphereSpec{1, false}, {}};
    TimedPoseSpec there;
    there.pose.position_m = {7, 8, 9};
    object.trajectory = TrajectorySpec{};
    object.trajectory->path = std::vector{there};
    object.trajectory->wave_motion = swell();
    scenario.objects.push_back(object);
  }
  return scenario;
}

}  // namespace

// Protects worlds against each other: an object's wave motion depends on seed, sequence and its
// name, not on what else there is.
TEST_CASE("the wave motion of an object is keyed by its name") {
  const auto pose_of_last = [](const Scenario& scenario, std::uint32_t sequence) {
    const auto world = build_world(scenario, sequence);
    REQUIRE(world.ok());
    return object_pose(world->objects.back(), 4);
  };
  const Pose alone = pose_of_last(with_movers({"b"}), 0);
  CHECK(pose_of_last(with_movers({"a", "b"}), 0) == alone);
  CHECK_FALSE(pose_of_last(with_movers({"a"}), 0) == alone);
  CHECK_FALSE(pose_of_last(with_movers({"b"}), 1) == alone);
  Scenario reseeded = with_movers({"b"});
  reseeded.seed = 7;
  CHECK_FALSE(pose_of_last(reseeded, 0) == alone);
}

// Protects moving objects: their pose by the pings' clock, at rest without a trajectory, and a
// file that is broken is told behind its key.
TEST_CASE("objects follow their trajectories") {
  Scenario scenario;
  scenario.materials = {{"steel", 0.01, {}, {}}};
  ObjectSpec still{"a", "x", "steel", SphereSpec{1, false}, {}};
  still.pose.position_m = {1, 2, 3};
  ObjectSpec moving{"b", "x", "steel", SphereSpec{1, false}, {}};
  OrbitSpec orbit;
  orbit.radius_m = 2;
  orbit.speed_m_s = kPi;
  orbit.start_time_s = 1000;
  moving.trajectory = TrajectorySpec{};
  moving.trajectory->path = orbit;
  scenario.objects = {still, moving};
  const auto world = build_world(scenario);
  REQUIRE(world.ok());
  CHECK_FALSE(world->objects[0].path);
  CHECK(object_pose(world->objects[0], 1001).position_m == Vec3{1, 2, 3});
  REQUIRE(world->objects[1].path);
  CHECK(world->objects[1].pose == object_pose(world->objects[1], 1000));
  CHECK(length(object_pose(world->objects[1], 1000).position_m - Vec3{2, 0, 0}) < 1e-12);
  CHECK(length(object_pose(world->objects[1], 1001).position_m - Vec3{0, 2, 0}) < 1e-12);
  scenario.objects[1].trajectory->path = PathFileSpec{"none.tum"};
  const auto broken = build_world(scenario);
  REQUIRE_FALSE(broken.ok());
  CHECK(broken.error().message.starts_with("objects.1.trajectory.file: none.tum: cannot be read"));
}
