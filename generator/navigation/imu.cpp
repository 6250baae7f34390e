#include "navigation/imu.h"

#include <algorithm>
#include <cmath>

#include "core/navigation_tables.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kHourS = 3600;
constexpr double kMicroG = 1e-6 * kGravityMS2;
constexpr int kProcesses = 11;
constexpr double kShortestS = 1.0 / 64;

// Processes of random numbers; flicker processes follow.
constexpr std::uint32_t kConstant = 0, kWhite = 1, kWalk = 2, kFlicker = 3;

using Axes = ImuErrors::Axes;

Axes axes_of(double rate, double force) { return {rate, rate, rate, force, force, force}; }

bool any(const Axes& axes) { return axes != Axes{}; }

struct State {
  double time_s = 0;
  Pose pose;
  Vec3 velocity_m_s;
};

void emit_truth(const State& state, const Axes& bias, const EmitRow& truth) {
  const auto& [p, q] = state.pose;
  const Vec3& v = state.velocity_m_s;
  const double row[] = {state.time_s, p.x, p.y,     p.z,     q.w,     q.x,     q.y,     q.z,    v.x,
                        v.y,          v.z, bias[0], bias[1], bias[2], bias[3], bias[4], bias[5]};
  truth(row);
}

// Angular rate and specific force over the time between two states.
Axes mean_motion(const State& begin, const State& end) {
  const double per_s = 1 / (end.time_s - begin.time_s);
  const Vec3 turn = rotation_vector(conjugate(begin.pose.rotation) * end.pose.rotation);
  const Quat middle = begin.pose.rotation * rotation_by(0.5 * turn);
  const Vec3 acceleration = per_s * (end.velocity_m_s - begin.velocity_m_s);
  const Vec3 rate = per_s * turn;
  const Vec3 force = rotate(conjugate(middle), acceleration + Vec3{0, 0, kGravityMS2});
  return {rate.x, rate.y, rate.z, force.x, force.y, force.z};
}

}  // namespace

ImuErrors::ImuErrors(const Imu& imu, std::uint64_t key) : key_(key) {
  const Gyroscope gyro = imu.gyroscope.value_or(Gyroscope{});
  const Accelerometer accel = imu.accelerometer.value_or(Accelerometer{});
  const double hour = std::sqrt(kHourS), step_s = 1 / imu.clock.rate_hz;
  white_ = axes_of(radians(gyro.angle_random_walk_deg_sqrth) / hour / std::sqrt(step_s),
                   accel.velocity_random_walk_m_s_sqrth / hour / std::sqrt(step_s));
  walk_step_ =
      axes_of(radians(gyro.rate_random_walk_deg_h_sqrth) / kHourS / hour * std::sqrt(step_s),
              kMicroG * accel.acceleration_random_walk_ug_sqrth / hour * std::sqrt(step_s));
  flicker_ =
      axes_of(radians(gyro.bias_instability_deg_h) / kHourS, kMicroG * accel.bias_instability_ug);
  constant_ = axes_of(radians(gyro.bias_deg_h) / kHourS, kMicroG * accel.bias_ug);
  const Axes constant = normals<6>(key_, kConstant, 0);
  for (int axis = 0; axis < 6; ++axis) constant_[axis] *= constant[axis];
  double time_s = kShortestS;
  for (int i = 0; any(flicker_) && i < kProcesses; ++i, time_s *= 4) {
    if (time_s < step_s) continue;
    const double keep = std::exp(-step_s / time_s);
    const auto process = kFlicker + static_cast<std::uint32_t>(processes_.size());
    processes_.push_back({keep, std::sqrt(1 - keep * keep), {}});
    // Stationary from the first sample on, which draws the numbers of sample 1.
    processes_.back().value = normals<6>(key_, process, 0);
  }
}

void ImuErrors::next() {
  if (sample_ > 0 && any(walk_step_)) {
    const Axes xi = normals<6>(key_, kWalk, sample_);
    for (int axis = 0; axis < 6; ++axis) walk_[axis] += walk_step_[axis] * xi[axis];
  }
  for (int axis = 0; axis < 6; ++axis) bias_[axis] = constant_[axis] + walk_[axis];
  for (std::size_t i = 0; i < processes_.size(); ++i) {
    auto& [keep, add, value] = processes_[i];
    const Axes xi = normals<6>(key_, kFlicker + static_cast<std::uint32_t>(i), sample_ + 1);
    for (int axis = 0; axis < 6; ++axis) {
      value[axis] = keep * value[axis] + add * xi[axis];
      bias_[axis] += flicker_[axis] * value[axis];
    }
  }
  error_ = bias_;
  if (any(white_)) {
    const Axes xi = normals<6>(key_, kWhite, sample_);
    for (int axis = 0; axis < 6; ++axis) error_[axis] += white_[axis] * xi[axis];
  }
  ++sample_;
}

void simulate_imu(const Imu& imu, const Course& course, const EmitRow& samples,
                  const EmitRow& truth) {
  const Pose mount = mount_of(imu.mount);
  const auto pose_at = [&](double time_s) { return compose(course.body_at(time_s), mount); };
  const auto time_of = [&](double number) { return sample_time_s(course, imu.clock, number); };
  // The state where sample `number` begins.
  const auto state_at = [&](double number) {
    const double last_s = time_of(number - 1), next_s = time_of(number);
    const double time_s = time_of(number - 0.5);
    const Vec3 way_m = pose_at(next_s).position_m - pose_at(last_s).position_m;
    return State{time_s, pose_at(time_s), (1 / (next_s - last_s)) * way_m};
  };
  ImuErrors errors(imu, sensor_key(course, "imu"));
  std::optional<State> begin;
  Axes bias{};
  for_each_sample(course, imu.clock, [&](std::uint64_t sample, double time_s) {
    errors.next();
    const auto number = static_cast<double>(sample);
    if (!is_kept(course, time_s) || !span_holds(course, time_of(number - 1)) ||
        !span_holds(course, time_of(number + 1))) {
      return;
    }
    if (!begin) begin = state_at(number);
    const State end = state_at(number + 1);
    Axes row = mean_motion(*begin, end);
    for (int axis = 0; axis < 6; ++axis) row[axis] += errors.error()[axis];
    const double values[] = {time_s, row[0], row[1], row[2], row[3], row[4], row[5]};
    samples(values);
    bias = errors.bias();
    emit_truth(*begin, bias, truth);
    begin = end;
  });
  if (begin) emit_truth(*begin, bias, truth);
}

}  // namespace ensonify
