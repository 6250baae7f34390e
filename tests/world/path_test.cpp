#include "world/path.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "is_refused.h"
#include "scenes.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects objects with times of their own next to a sonar with times of the epoch.
TEST_CASE("a path can be moved in time") {
  const TemporaryFolder folder;
  const auto file = path_from(folder.write("a.tum", "5 0 0 0 0 0 0 1\n7 2 0 0 0 0 0 1\n"));
  const auto path = load_path(file, 0, 1.6e9);
  REQUIRE(path.ok());
  CHECK(span_of(*path).start_s == 1.6e9);
  CHECK(pose_at(*path, 1.6e9 + 1).position_m.x == Approx(1));
  TrajectorySpec orbit;
  orbit.path = OrbitSpec{.radius_m = 2, .speed_m_s = 1, .start_time_s = 30};
  const auto early = load_path(orbit, 0), late = load_path(orbit, 0, 100);
  CHECK(span_of(*late).start_s == 100);
  CHECK(length(pose_at(*late, 103).position_m - pose_at(*early, 33).position_m) < 1e-12);
}

// Protects the number of pings: both ends of the path included, its first stamp the start, and
// nothing invented past its end.
TEST_CASE("ping times") {
  const Path path{SampledPath{{{100, {}}, {103, {}}}}, {}};
  TrajectorySpec spec;
  spec.ping_rate_hz = 10;
  const auto whole = ping_times(spec, path);
  REQUIRE(whole.ok());
  CHECK(whole->size() == 31);
  CHECK(whole->front() == 100);
  CHECK(whole->back() == Approx(103));
  spec.pings = 5;
  CHECK(ping_times(spec, path)->size() == 5);
  spec.pings = 32;
  CHECK_FALSE(ping_times(spec, path).ok());
  const Path still{SampledPath{{{0, {}}}}, {}};
  CHECK(ping_times(spec, still)->size() == 32);
}

// Protects dropped frames: those that stay keep their times, as many are dropped as was asked, and
// a path that ends gives fewer pings.
TEST_CASE("dropped frames leave gaps") {
  const Path still{SampledPath{{{3, {}}}}, {}};
  TrajectorySpec spec;
  spec.ping_rate_hz = 4;
  spec.pings = 4000;
  const FrameDrops drops{11, 0.25};
  const auto times = ping_times(spec, still, drops);
  REQUIRE(times.ok());
  REQUIRE(times->size() == 4000);
  CHECK(times->front() == 3);
  for (std::size_t k = 1; k < times->size(); ++k) {
    const double periods = ((*times)[k] - (*times)[k - 1]) * 4;
    CHECK(periods == Approx(std::round(periods)));
    CHECK(periods > 0.9);
  }
  // 4000 of 4000/0.75 frames; their standard deviation is sqrt(4000 * 0.25)/0.75 = 42.
  CHECK((times->back() - 3) * 4 == Approx(4000 / 0.75).margin(4 * 42));
  CHECK(ping_times(spec, still, drops).ok());
  CHECK(*ping_times(spec, still, FrameDrops{12, 0.25}) != *times);

  const Path path{SampledPath{{{0, {}}, {100, {}}}}, {}};
  spec.pings.reset();
  const auto some = ping_times(spec, path, drops);
  REQUIRE(some.ok());
  CHECK(some->size() < 401);
  CHECK(some->back() <= 100);
  spec.pings = 401;
  const auto all = ping_times(spec, path, drops);
  CHECK(is_refused(all, "without dropped frames"));
}

// Protects recorded paths: at Unix times a stamp's last digit is 2e-7 s.
TEST_CASE("large stamps cost no ping") {
  const Path path{SampledPath{{{1700000000.0, {}}, {1700000000.6, {}}}}, {}};
  TrajectorySpec spec;
  spec.ping_rate_hz = 5;
  const auto times = ping_times(spec, path);
  REQUIRE(times.ok());
  CHECK(times->size() == 4);
}

// Protects `pings` left out: a way by a formula has a length of its own.
TEST_CASE("ways by formula hold as many pings as they last") {
  TrajectorySpec spec;
  spec.ping_rate_hz = 2;
  OrbitSpec orbit;
  orbit.radius_m = 5 / kPi;
  orbit.speed_m_s = 1;
  orbit.start_time_s = 50;
  spec.path = orbit;
  const auto path = load_path(spec, 0);
  REQUIRE(path.ok());
  const auto times = ping_times(spec, *path);
  REQUIRE(times.ok());
  CHECK(times->size() == 21);
  CHECK(times->front() == 50);
  CHECK(times->back() == Approx(60));
  spec.pings = 22;
  CHECK_FALSE(ping_times(spec, *path).ok());
  spec.ping_rate_hz = 1e6;
  spec.pings.reset();
  const auto many = ping_times(spec, *path);
  CHECK(is_refused(many, "at most 1000000"));
}

namespace {

Vec3 ahead(const Pose& pose) { return rotate(pose.rotation, {1, 0, 0}); }
Vec3 above(const Pose& pose) { return rotate(pose.rotation, {0, 0, 1}); }

// The same turn whatever the quaternion's sign: its angle.
double angle_between(const Pose& a, const Pose& b) {
  const Quat q = conjugate(a.rotation) * b.rotation;
  return 2 * std::atan2(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z), std::abs(q.w));
}

LawnmowerSpec mowing() {
  LawnmowerSpec spec;
  spec.corner_m = {10, 20, -3};
  spec.length_m = 30;
  spec.width_m = 9;
  spec.spacing_m = 4;
  spec.heading_deg = 90;
  spec.speed_m_s = 1.5;
  spec.start_time_s = 100;
  return spec;
}

SplineSpec bent() {
  SplineSpec spec;
  spec.points_m = {{0, 0, 0}, {4, 1, -1}, {5, 6, -1.5}, {5.2, 6.1, -1.4}, {-3, 8, 2}, {-3, -2, 0}};
  spec.speed_m_s = 0.8;
  spec.start_time_s = -7;
  return spec;
}

}  // namespace

// Protects the geometry of a survey: lines as long and as far apart as asked for, as many as the
// width holds, to port of the first one, the second one run backwards.
TEST_CASE("lawnmower lines lie where they should") {
  const LawnmowerSpec path = mowing();
  const double line_s = 30 / 1.5, turn_s = kPi * 2 / 1.5;
  CHECK(span_of(path).start_s == 100);
  CHECK(span_of(path).end_s == Approx(100 + 3 * line_s + 2 * turn_s));
  // The first line goes north from the corner; port is west.
  for (int line = 0; line < 3; ++line) {
    const double begin_s = 100 + line * (line_s + turn_s);
    const bool back = line == 1;
    for (const double u : {0.0, 0.25, 1.0}) {
      INFO("line " << line << " at " << u);
      const Pose pose = pose_at(path, begin_s + u * line_s);
      const double y = 20 + 30 * (back ? 1 - u : u);
      CHECK(length(pose.position_m - Vec3{10 - 4.0 * line, y, -3}) < 1e-9);
      CHECK(length(ahead(pose) - Vec3{0, back ? -1.0 : 1.0, 0}) < 1e-9);
      CHECK(length(above(pose) - Vec3{0, 0, 1}) < 1e-12);
    }
  }
  CHECK(pose_at(path, 0) == pose_at(path, 100));
  CHECK(length(pose_at(path, 1e6).position_m - Vec3{2, 50, -3}) < 1e-9);
  CHECK(length(ahead(pose_at(path, 1e6)) - Vec3{0, 1, 0}) < 1e-9);
}

// Protects the turns: half circles outside the lines, at the same speed.
TEST_CASE("lawnmower turns are half circles") {
  const LawnmowerSpec path = mowing();
  const double line_s = 30 / 1.5, turn_s = kPi * 2 / 1.5;
  const Vec3 centers[] = {{8, 50, -3}, {4, 20, -3}};
  for (int turn = 0; turn < 2; ++turn) {
    const double begin_s = 100 + line_s + turn * (line_s + turn_s);
    for (const double u : {0.1, 0.5, 0.9}) {
      INFO("turn " << turn << " at " << u);
      const Pose pose = pose_at(path, begin_s + u * turn_s);
      CHECK(length(pose.position_m - centers[turn]) == Approx(2));
      CHECK(std::abs(dot(ahead(pose), pose.position_m - centers[turn])) < 1e-9);
    }
    CHECK(length(pose_at(path, begin_s + turn_s / 2).position_m - centers[turn] -
                 Vec3{0, turn == 0 ? 2.0 : -2.0, 0}) < 1e-9);
  }
}

TEST_CASE("the number of lawnmower lines is what the width holds") {
  const auto lines = [](double width_m, double spacing_m) {
    LawnmowerSpec spec = mowing();
    spec.width_m = width_m;
    spec.spacing_m = spacing_m;
    return line_count(spec);
  };
  CHECK(lines(0, 4) == 1);
  CHECK(lines(3.999, 4) == 1);
  CHECK(lines(4, 4) == 2);
  CHECK(lines(0.3, 0.1) == 4);  // 0.3 / 0.1 is 2.9999999999999996
}

// Protects bearing, sense and heading of orbits against the closed form.
TEST_CASE("orbit positions and headings") {
  OrbitSpec spec;
  spec.center_m = {1, 2, -5};
  spec.radius_m = 4;
  spec.speed_m_s = 0.5;
  spec.start_deg = 30;
  spec.start_time_s = 10;
  for (const double turns : {2.25, -1.5}) {
    for (const OrbitLook look : {OrbitLook::inward, OrbitLook::outward, OrbitLook::along}) {
      spec.turns = turns;
      spec.look = look;
      const OrbitSpec& path = spec;
      const double lasts_s = std::abs(turns) * 2 * kPi * 4 / 0.5;
      CHECK(span_of(path).end_s == Approx(10 + lasts_s));
      for (const double u : {0.0, 0.3, 0.77, 1.0}) {
        INFO("turns " << turns << " at " << u);
        const Pose pose = pose_at(path, 10 + u * lasts_s);
        const double bearing = radians(30 + 360 * turns * u);
        const Vec3 out{std::cos(bearing), std::sin(bearing), 0};
        CHECK(length(pose.position_m - (Vec3{1, 2, -5} + 4.0 * out)) < 1e-9);
        const double sense = turns > 0 ? 1 : -1;
        const Vec3 forward = sense * cross({0, 0, 1}, out);
        const Vec3 wanted = look == OrbitLook::inward    ? -out
                            : look == OrbitLook::outward ? out
                                                         : forward;
        CHECK(length(ahead(pose) - wanted) < 1e-9);
        CHECK(length(above(pose) - Vec3{0, 0, 1}) < 1e-12);
      }
    }
  }
}

// Protects the two promises of a spline: it passes through its points in their order, and at any
// instant it goes at the speed asked for. The speed by central differences over 2e-4 s of both
// halves of each 0.01 s; where a point is passed the difference sees both sides of it.
TEST_CASE("a spline passes its points at constant speed") {
  const SplineSpec spec = bent();
  const SplinePath path = make_path(spec);
  const TimeSpan span = span_of(path);
  CHECK(span.start_s == -7);
  std::size_t reached = 0;
  double travelled_m = 0;
  Vec3 last = pose_at(path, span.start_s).position_m;
  const int steps = 3000;
  for (int i = 0; i <= steps; ++i) {
    const double t = span.start_s + (span.end_s - span.start_s) * i / steps;
    const Pose pose = pose_at(path, t);
    travelled_m += length(pose.position_m - last);
    last = pose.position_m;
    const auto& p = spec.points_m[std::min(reached, spec.points_m.size() - 1)];
    const Vec3 left = Vec3{p[0], p[1], p[2]} - pose.position_m;
    // Half a step of the path is 0.0045 m.
    if (reached < spec.points_m.size() && length(left) < 0.0046) ++reached;
    if (i == 0 || i == steps) continue;
    const double h = 1e-4;
    const Vec3 speed =
        (1 / (2 * h)) * (pose_at(path, t + h).position_m - pose_at(path, t - h).position_m);
    INFO("time " << t);
    CHECK(length(speed) == Approx(0.8).epsilon(1e-6));
    CHECK(dot(ahead(pose), normalized(speed)) == Approx(1).margin(1e-5));
    CHECK(std::abs(rotate(pose.rotation, {0, 1, 0}).z) < 1e-12);
  }
  CHECK(reached == spec.points_m.size());
  // Chords of 0.009 m fall short of an arc of radius R by (0.009 / R)^2 / 24.
  CHECK(travelled_m == Approx(0.8 * (span.end_s - span.start_s)).epsilon(1e-4));
}

// Protects the ends and every point to the last digits, not only to half a step.
TEST_CASE("a spline holds its points exactly") {
  const SplineSpec spec = bent();
  const SplinePath path = make_path(spec);
  for (std::size_t i = 0; i < spec.points_m.size(); ++i) {
    const double arc_m = i < path.segments.size() ? path.segments[i].arc_m.front()
                                                  : path.segments.back().arc_m.back();
    const auto& p = spec.points_m[i];
    const Vec3 there = pose_at(path, -7 + arc_m / 0.8).position_m;
    INFO("point " << i);
    CHECK(length(there - Vec3{p[0], p[1], p[2]}) < 1e-9);
  }
  CHECK(pose_at(path, -100) == pose_at(path, -7));
  CHECK(length(pose_at(path, 1e4).position_m - Vec3{-3, -2, 0}) < 1e-9);
}

// Protects the kind of spline: centripetal ones divide the half angle at a point, whatever the
// distances, and neither loop nor leave the corner on the far side.
TEST_CASE("the direction at a point halves its angle") {
  SplineSpec spec;
  spec.points_m = {{0, 0, 0}, {10, 0, 0}, {10, 0.5, 0}, {10, 3, 0}};
  spec.speed_m_s = 1;
  const SplinePath path = make_path(spec);
  const Vec3 direction = ahead(pose_at(path, path.segments[1].arc_m[0]));
  CHECK(length(direction - Vec3{std::sqrt(0.5), std::sqrt(0.5), 0}) < 1e-9);
}

TEST_CASE("a spline of two points is a straight line") {
  SplineSpec spec;
  spec.points_m = {{1, 1, 1}, {1, 5, 4}};
  spec.speed_m_s = 2;
  const SplinePath path = make_path(spec);
  CHECK(span_of(path).end_s == Approx(2.5));
  const Pose pose = pose_at(path, 0.5);
  CHECK(length(pose.position_m - Vec3{1, 1.8, 1.6}) < 1e-12);
  CHECK(length(ahead(pose) - Vec3{0, 0.8, 0.6}) < 1e-12);
  spec.look_at_m = {1, 1.8, -10};
  CHECK(length(ahead(pose_at(make_path(spec), 0.5)) - Vec3{0, 0, -1}) < 1e-12);
}

TEST_CASE("a spline can look at a point") {
  SplineSpec spec = bent();
  spec.look_at_m = {20, -4, 3};
  const SplinePath path = make_path(spec);
  for (const double t : {-7.0, 0.0, 13.3}) {
    const Pose pose = pose_at(path, t);
    CHECK(length(ahead(pose) - normalized(Vec3{20, -4, 3} - pose.position_m)) < 1e-12);
  }
}

// Protects everything that goes on from pose to pose: no rotation jumps. Steps of a thousandth of
// a second at 1.5 m/s on a radius of 2 m turn by 7.5e-4 rad; the spline's tightest bend has a
// radius over 0.01 m, an eightieth of a radian in 1e-3 s.
TEST_CASE("attitudes are continuous") {
  const auto largest_step = [](const auto& path) {
    const TimeSpan span = span_of(path);
    double most = 0;
    Pose last = pose_at(path, span.start_s);
    for (double t = span.start_s; t < span.end_s; t += 1e-3) {
      const Pose pose = pose_at(path, t);
      most = std::max(most, angle_between(last, pose));
      last = pose;
    }
    return most;
  };
  CHECK(largest_step(mowing()) < 7.6e-4);
  OrbitSpec orbit;
  orbit.radius_m = 2;
  orbit.speed_m_s = 1.5;
  orbit.turns = -3;
  CHECK(largest_step(orbit) < 7.6e-4);
  CHECK(largest_step(make_path(bent())) < 0.08);
}
