#include "world/pose_track.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "world/path.h"

using namespace ensonify;

namespace {

constexpr double kSpan_s = 0.084;

Path path_of(TrajectorySpec spec, bool waves) {
  if (waves) spec.wave_motion = WaveMotionSpec{3, 2, 4, 0.05, 1.5, 0.2};
  auto path = load_path(spec, 77);
  REQUIRE(path.ok());
  return std::move(*path);
}

// Corners of way and heading every 30 ms, as of a logger.
TrajectorySpec logged(double start_s) {
  std::vector<TimedPoseSpec> poses;
  for (int i = 0; i < 40; ++i) {
    const auto draw = [&](std::uint32_t d) { return uniform(5, 0, i, d); };
    poses.push_back({start_s + 0.03 * i,
                     {{0.05 * i + 0.01 * draw(0), 0.02 * draw(1), 0.01 * draw(2)},
                      std::array<double, 3>{draw(3), draw(4), 3 * i + draw(5)}}});
  }
  return {poses, std::nullopt, 10, 1};
}

TrajectorySpec bent_path() {
  SplineSpec spec;
  spec.points_m = {{0, 0, 0}, {4, 1, -1}, {5, 6, -1.5}, {-3, 8, 2}};
  spec.speed_m_s = 3;
  return {spec, std::nullopt, 10, 1};
}

TrajectorySpec orbit() {
  OrbitSpec spec;
  spec.radius_m = 3;
  spec.speed_m_s = 5;
  return {spec, std::nullopt, 10, 1};
}

double small_angle_between(const Pose& a, const Pose& b) {
  const Quat q = conjugate(a.rotation) * b.rotation;
  return 2 * std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
}

}  // namespace

// Protects the phase of echoes: 1e-9 m are 4e-6 rad at 900 kHz.
TEST_CASE("a pose track is its body's way, corners and wave motion included") {
  const bool waves = GENERATE(false, true);
  const int kind = GENERATE(0, 1, 2);
  const Path path = path_of(kind == 0 ? logged(0) : kind == 1 ? bent_path() : orbit(), waves);
  for (const double start : {0.0, 0.0123, 0.5}) {
    const PoseTrack track([&](double t) { return pose_at(path, t); }, start, kSpan_s);
    CHECK_FALSE(track.rests());
    double worst_m = 0, worst_rad = 0;
    for (int i = 0; i < 4000; ++i) {
      // Some lie beyond the span.
      const double t = 1.2 * kSpan_s * i / 4000;
      const Pose right = pose_at(path, start + t), got = track.at(t);
      worst_m = std::max(worst_m, length(got.position_m - right.position_m));
      worst_m = std::max(worst_m, length(track.position(t) - right.position_m));
      worst_rad = std::max(worst_rad, small_angle_between(got, right));
    }
    CHECK(worst_m < 1e-10);
    CHECK(worst_rad < 1e-12);
  }
}

// A clock that counts from 1970 tells times to 2.4e-7 s only: poses are those of the instants it
// can hold, and in between they do not jump.
TEST_CASE("a pose track of a late clock is smooth") {
  const double start = 1'700'000'000.125;
  const std::vector<TimedPoseSpec> poses = {{start, {{1, 2, 3}, std::array<double, 3>{}}},
                                            {start + 1, {{4, 2, 3}, std::array<double, 3>{}}}};
  const Path path = path_of({poses, std::nullopt, 1, 1}, false);
  const PoseTrack track([&](double t) { return pose_at(path, t); }, start, kSpan_s);
  for (int i = 0; i < 1000; ++i) {
    const double t = kSpan_s * i / 1000;
    REQUIRE(std::abs(track.position(t).x - (1 + 3 * t)) < 1e-12);
    REQUIRE(track.velocity(t).x == Approx(3).epsilon(1e-9));
  }
}

// Protects the Doppler shift: v/c to 1e-9 is 1.5e-6 m/s. The start of a way is its start, though
// the body rests before it.
TEST_CASE("velocities of a turning body, from the start on") {
  const Path path = path_of(orbit(), false);
  const PoseTrack track([&](double t) { return pose_at(path, t); }, 0, kSpan_s);
  for (const double t : {0.0, 3e-5, 1e-3, 0.05}) {
    // At bearing a = v t/r from the centre, looking at it, a point 1 m ahead goes at 2/3 of it.
    const double a = 5 * t / 3;
    const Vec3 along{-std::sin(a), std::cos(a), 0};
    CHECK(length(track.velocity(t) - 5 * along) < 1e-6);
    CHECK(length(track.velocity(t, {1, 0, 0}) - (10.0 / 3) * along) < 1e-6);
  }
}

TEST_CASE("a body at rest is known to be") {
  const Path path = path_of({std::vector<TimedPoseSpec>(1), std::nullopt, 1, 1}, false);
  CHECK(PoseTrack([&](double t) { return pose_at(path, t); }, 3, kSpan_s).rests());
  const Path moving = path_of(bent_path(), false);
  CHECK(PoseTrack([&](double t) { return pose_at(moving, t); }, 1e4, kSpan_s).rests());
}
