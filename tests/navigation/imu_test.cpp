#include "navigation/imu.h"

#include <algorithm>
#include <cmath>
#include "catch.h"

#include "core/units.h"
#include "courses.h"

namespace ensonify {
namespace {

constexpr double kG = 9.80665;

struct Simulated {
  SensorRows samples, truth;
};

Simulated simulated(const Imu& imu, const Course& course) {
  Simulated made;
  simulate_imu(imu, course, collect(made.samples), collect(made.truth));
  return made;
}

Imu imu_at(double rate_hz) {
  Imu imu;
  imu.clock.rate_hz = rate_hz;
  imu.mount = SensorMount{{0.4, -0.1, 0.2}, {170, 5, 30}};
  return imu;
}

Pose mounted(const Course& course, double time_s) {
  return compose(course.body_at(time_s),
                 {{0.4, -0.1, 0.2}, from_roll_pitch_yaw(radians(170), radians(5), radians(30))});
}

double angle_between(Quat a, Quat b) { return length(rotation_vector(conjugate(a) * b)); }

Quat quat_at(const std::vector<double>& row, std::size_t i) {
  return {row[i], row[i + 1], row[i + 2], row[i + 3]};
}

// Straight pieces with corners, between turns at constant rates.
Path cornered() {
  TrajectorySpec spec;
  spec.path = std::vector<TimedPoseSpec>{{0, {{0, 0, 0}}},
                                         {1.013, {{1, 0, 0}, std::array{0.0, 0.0, 40.0}}},
                                         {2.107, {{1.5, 0.7, -0.2}, std::array{10.0, -20.0, 90.0}}},
                                         {3, {{1, 1, 0.3}, std::array{0.0, 15.0, 200.0}}}};
  return path_of(spec);
}

Path wavy_orbit() {
  TrajectorySpec spec;
  OrbitSpec orbit;
  orbit.radius_m = 10;
  orbit.speed_m_s = 1.2;
  orbit.look = OrbitLook::along;
  spec.path = orbit;
  spec.wave_motion = WaveMotionSpec{2, 1.5, 1, 0.05, 6};
  return path_of(spec);
}

}  // namespace

TEST_CASE("samples give the positions and attitudes of a path with corners back") {
  const Path path = cornered();
  const Course course = course_on(path, 0, 3);
  const Imu imu = imu_at(50);
  const auto [samples, truth] = simulated(imu, course);
  REQUIRE(samples.size() == 149);  // without the two at the ends of the path
  REQUIRE(truth.size() == samples.size() + 1);
  const double t = 1.0 / 50;
  Quat q = quat_at(truth[0], 4);
  Vec3 v = vec_at(truth[0], 8), p = mounted(course, samples[0][0]).position_m;
  double worst_m = 0, worst_rad = 0;
  for (const auto& row : samples) {
    const Vec3 turn = t * vec_at(row, 1);
    v = v + t * (rotate(q * rotation_by(0.5 * turn), vec_at(row, 4)) - Vec3{0, 0, kG});
    p = p + t * v;
    q = q * rotation_by(turn);
    worst_m = std::max(worst_m, length(p - mounted(course, row[0] + t).position_m));
    worst_rad = std::max(worst_rad, angle_between(q, mounted(course, row[0] + t / 2).rotation));
  }
  CHECK(worst_m < 1e-9);
  CHECK(worst_rad < 1e-11);
}

// An integrator of others: attitude and force are constant over a sample, from its begin to its
// end. The position is off by T^2 / 8 times the change of the acceleration, 3e-7 m.
TEST_CASE("preintegration of samples follows a smooth path to 1e-6 m") {
  const Path path = wavy_orbit();
  const Course course = course_on(path, 0, 8);
  const auto [samples, truth] = simulated(imu_at(400), course);
  REQUIRE(samples.size() > 3000);
  const double t = 1.0 / 400;
  Quat q = quat_at(truth[0], 4);
  Vec3 v = vec_at(truth[0], 8), p = vec_at(truth[0], 1);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Vec3 turn = t * vec_at(samples[k], 1);
    const Vec3 a = rotate(q * rotation_by(0.5 * turn), vec_at(samples[k], 4)) - Vec3{0, 0, kG};
    p = p + t * v + 0.5 * t * t * a;
    v = v + t * a;
    q = q * rotation_by(turn);
  }
  const auto& last = truth.back();
  CHECK(length(vec_at(last, 1) - mounted(course, last[0]).position_m) < 1e-12);
  CHECK(length(p - vec_at(last, 1)) < 1e-6);
  CHECK(length(v - vec_at(last, 8)) < 1e-9);
  CHECK(angle_between(q, quat_at(last, 4)) < 1e-11);
}

TEST_CASE("a circle has its angular rate and centripetal acceleration") {
  TrajectorySpec spec;
  OrbitSpec orbit;
  orbit.radius_m = 4;
  orbit.speed_m_s = 2;
  orbit.look = OrbitLook::along;
  spec.path = orbit;
  const Path path = path_of(spec);
  Imu imu;
  imu.clock.rate_hz = 100;
  const auto [samples, truth] = simulated(imu, course_on(path, 0, 5));
  // Counterclockwise: the center is to port. The mean over both samples is sinc^2(w T / 2).
  const double half = 0.5 * (2.0 / 4) / 100, sinc = std::sin(half) / half;
  for (const auto& row : samples) {
    CHECK(length(vec_at(row, 1) - Vec3{0, 0, 0.5}) < 1e-10);
    CHECK(length(vec_at(row, 4) - Vec3{0, sinc * sinc, kG}) < 1e-8);
  }
}

TEST_CASE("a window of time has the rows of the whole") {
  const Path path = wavy_orbit();
  Imu imu = imu_at(20);
  imu.gyroscope = Gyroscope{0.1, 2, 1, 10};
  imu.accelerometer = Accelerometer{0.05, 20, 30, 100};
  const auto [all, all_truth] = simulated(imu, course_on(path, 0, 6));
  Course part = course_on(path, 0, 6);
  part.from_s = 2;
  part.to_s = 4;
  const auto [some, some_truth] = simulated(imu, part);
  REQUIRE(some.size() == 41);
  const auto first = std::find(all.begin(), all.end(), some[0]);
  REQUIRE(first != all.end());
  CHECK(std::equal(some.begin(), some.end(), first));
  // Its biases are the errors without white noise.
  CHECK(some_truth[0] == all_truth[static_cast<std::size_t>(first - all.begin())]);
}

namespace {

// Variances of the axes 0 to 2 and 3 to 5 of the differences between means of `count` samples.
std::array<double, 2> allan_variance(const std::vector<ImuErrors::Axes>& errors,
                                     std::size_t count) {
  std::array<double, 2> sums{};
  const std::size_t clusters = errors.size() / count;
  for (int axis = 0; axis < 6; ++axis) {
    double before = 0;
    for (std::size_t cluster = 0; cluster < clusters; ++cluster) {
      double mean = 0;
      for (std::size_t i = 0; i < count; ++i) mean += errors[cluster * count + i][axis];
      mean /= static_cast<double>(count);
      if (cluster > 0) sums[axis / 3] += (mean - before) * (mean - before) / 2;
      before = mean;
    }
  }
  for (double& sum : sums) sum /= 3.0 * static_cast<double>(clusters - 1);
  return sums;
}

std::vector<ImuErrors::Axes> errors_of(const Gyroscope& gyro, const Accelerometer& accel,
                                       double rate_hz, std::size_t count) {
  Imu imu;
  imu.clock.rate_hz = rate_hz;
  imu.gyroscope = gyro;
  imu.accelerometer = accel;
  ImuErrors errors(imu, 99);
  std::vector<ImuErrors::Axes> made;
  for (std::size_t k = 0; k < count; ++k) {
    errors.next();
    made.push_back(errors.error());
  }
  return made;
}

constexpr double kDegH = kPi / 180 / 3600, kMicroG = 1e-6 * kG;

}  // namespace

// The relative standard error of a variance from 3 axes of M differences is below sqrt(1 / M) with
// all their correlations (2/3 / M for white noise, 3/4 / M for the others).
TEST_CASE("the Allan deviation of white noise falls by half a decade in a decade") {
  constexpr std::size_t kSamples = 1 << 15;
  const auto errors = errors_of({0.3, 0, 0, 0}, {0.06, 0, 0, 0}, 100, kSamples);
  for (const std::size_t count : {1u, 8u, 64u, 512u}) {
    const double tau_s = static_cast<double>(count) / 100;
    const double gyro = radians(0.3) / 60 / std::sqrt(tau_s), accel = 0.06 / 60 / std::sqrt(tau_s);
    const auto found = allan_variance(errors, count);
    const double error = std::sqrt(static_cast<double>(count) / kSamples);
    CHECK(found[0] / (gyro * gyro) == Approx(1).margin(3 * error));
    CHECK(found[1] / (accel * accel) == Approx(1).margin(3 * error));
  }
}

TEST_CASE("the Allan deviation of the bias instability is flat") {
  constexpr std::size_t kSamples = 1 << 16;
  const auto errors = errors_of({0, 5, 0, 0}, {0, 40, 0, 0}, 4, kSamples);
  for (const std::size_t count : {64u, 256u, 1024u}) {
    const auto found = allan_variance(errors, count);
    const double error = std::sqrt(static_cast<double>(count) / kSamples);
    CHECK(found[0] / (5 * kDegH * 5 * kDegH) == Approx(1).margin(3 * error + 0.02));
    CHECK(found[1] / (40 * kMicroG * 40 * kMicroG) == Approx(1).margin(3 * error + 0.02));
  }
}

TEST_CASE("the Allan deviation of the rate random walk rises by half a decade in a decade") {
  constexpr std::size_t kSamples = 1 << 14;
  const auto errors = errors_of({0, 0, 6, 0}, {0, 0, 80, 0}, 10, kSamples);
  for (const std::size_t count : {8u, 32u, 128u}) {
    const double tau_s = static_cast<double>(count) / 10;
    // A walk by steps: the factor is 1 + 1/(2 n^2).
    const double steps = 1 + 0.5 / (static_cast<double>(count) * static_cast<double>(count));
    const double gyro = 6 * kDegH / 60, accel = 80 * kMicroG / 60;
    const auto found = allan_variance(errors, count);
    const double error = std::sqrt(static_cast<double>(count) / kSamples);
    CHECK(found[0] / (gyro * gyro * tau_s / 3 * steps) == Approx(1).margin(3 * error));
    CHECK(found[1] / (accel * accel * tau_s / 3 * steps) == Approx(1).margin(3 * error));
  }
}

// At rest over T, the velocity along x and y has the variance VRW^2 T + (g ARW)^2 T^3 / 3, and each
// attitude ARW^2 T. 200 runs of two axes: relative standard error sqrt(2 / 400) = 7 %; of three
// angles: 6 %.
TEST_CASE("integrated samples drift by the random walks of the data sheet") {
  Imu imu;
  imu.clock.rate_hz = 10;
  imu.gyroscope = Gyroscope{0.3, 0, 0, 0};
  imu.accelerometer = Accelerometer{0.1, 0, 0, 0};
  const Path path = at_rest();
  const double end_s = 30, t = 0.1;
  double velocity2 = 0, angle2 = 0;
  for (std::uint64_t run = 0; run < 200; ++run) {
    const auto [samples, truth] = simulated(imu, course_on(path, 0, end_s - t / 2, run));
    REQUIRE(samples.size() == 300);
    Quat q;
    Vec3 v;
    for (const auto& row : samples) {
      v = v + t * (rotate(q, vec_at(row, 4)) - Vec3{0, 0, kG});
      q = q * rotation_by(t * vec_at(row, 1));
    }
    velocity2 += (v.x * v.x + v.y * v.y) / 400;
    angle2 += dot(rotation_vector(q), rotation_vector(q)) / 600;
  }
  const double arw = radians(0.3) / 60, vrw = 0.1 / 60;
  CHECK(angle2 / (arw * arw * end_s) == Approx(1).margin(0.18));
  CHECK(velocity2 / (vrw * vrw * end_s + kG * kG * arw * arw * end_s * end_s * end_s / 3) ==
        Approx(1).margin(0.21));
}

TEST_CASE("the constant bias has its standard deviation over sequences") {
  Imu imu;
  imu.clock.rate_hz = 1;
  imu.gyroscope = Gyroscope{0, 0, 0, 10};
  imu.accelerometer = Accelerometer{0, 0, 0, 500};
  double gyro2 = 0, accel2 = 0;
  for (std::uint64_t key = 0; key < 1000; ++key) {
    ImuErrors errors(imu, key);
    errors.next();
    const auto first = errors.error();
    errors.next();
    CHECK(errors.error() == first);
    gyro2 += first[0] * first[0] / 1000;
    accel2 += first[4] * first[4] / 1000;
  }
  // Relative standard error sqrt(2 / 1000) = 4.5 %.
  CHECK(gyro2 / (100 * kDegH * kDegH) == Approx(1).margin(0.135));
  CHECK(accel2 / (500 * kMicroG * 500 * kMicroG) == Approx(1).margin(0.135));
}

}  // namespace ensonify
