// The motion of the body as its navigation sensors sample it.
//
//   Course              the body's path, and which samples are kept
//   is_kept  span_holds
//   for_each_sample     times of a sensor's samples
//   Motion  motion_at   velocity and angular rate of a frame on the body
//   rotation_vector  rotation_by
//   sensor_key  normals    random numbers of a sensor
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/navigation.h"
#include "core/random.h"
#include "core/vec.h"
#include "world/path.h"

namespace ensonify {

struct Course {
  std::function<Pose(double)> body_at;  // body in the world at a time
  TimeSpan span;                        // of the path; a body at rest has one of no length
  double start_s = 0;                   // from which sensors count their samples
  double from_s = 0, to_s = 0;          // rows outside are left out
  std::uint64_t key = 0;                // of Stream::navigation
};

// Takes a row of a table, in the order of its columns.
using EmitRow = std::function<void(std::span<const double>)>;

inline bool is_kept(const Course& course, double time_s) {
  return time_s >= course.from_s && time_s <= course.to_s;
}

// Whether the body is on its path at this time. A moving body would start and stop with a jerk at
// the ends, beyond which it rests.
inline bool span_holds(const Course& course, double time_s) {
  const auto& [start_s, end_s] = course.span;
  return start_s == end_s || (time_s >= start_s && time_s <= end_s);
}

inline double sample_time_s(const Course& course, const SensorClock& clock, double number) {
  return course.start_s + clock.time_offset_s + number / clock.rate_hz;
}

// Calls use(number, time_s) for every sample up to the last that is kept, those before the first
// kept one too, since errors have a history.
template <class Use>
void for_each_sample(const Course& course, const SensorClock& clock, Use use) {
  for (std::uint64_t k = 0;; ++k) {
    const double time_s = sample_time_s(course, clock, static_cast<double>(k));
    if (time_s > course.to_s) return;
    use(k, time_s);
  }
}

// The rotation by |v| about v, and back, with an angle of at most pi.
inline Quat rotation_by(Vec3 v) {
  const double angle = length(v);
  const double scale = angle > 1e-9 ? std::sin(angle / 2) / angle : 0.5;
  return normalized(Quat{std::cos(angle / 2), scale * v.x, scale * v.y, scale * v.z});
}
inline Vec3 rotation_vector(Quat q) {
  const double sign = q.w < 0 ? -1 : 1;
  const Vec3 v{sign * q.x, sign * q.y, sign * q.z};
  const double sine = length(v);
  return (sine > 1e-9 ? 2 * std::atan2(sine, sign * q.w) / sine : 2.0) * v;
}

struct Motion {
  Pose pose;          // in the world
  Vec3 velocity_m_s;  // in the frame itself
  Vec3 angular_rate_rad_s;
};

// Of a frame on the body, by differences over 1 ms on either side, within the path.
inline Motion motion_at(const Course& course, const Pose& mount, double time_s) {
  constexpr double kStepS = 1e-3;
  double before_s = time_s - kStepS, after_s = time_s + kStepS;
  if (!span_holds(course, before_s)) before_s = time_s;
  if (!span_holds(course, after_s)) after_s = time_s;
  const Pose before = compose(course.body_at(before_s), mount);
  const Pose after = compose(course.body_at(after_s), mount);
  Motion motion{compose(course.body_at(time_s), mount), {}, {}};
  if (before_s == after_s) return motion;
  const double per_s = 1 / (after_s - before_s);
  motion.velocity_m_s =
      per_s * rotate(conjugate(motion.pose.rotation), after.position_m - before.position_m);
  motion.angular_rate_rad_s = per_s * rotation_vector(conjugate(before.rotation) * after.rotation);
  return motion;
}

inline std::uint64_t sensor_key(const Course& course, std::string_view sensor) {
  return mix64(course.key ^ name_key(sensor));
}

// Standard normal numbers of a sample; those of different processes are independent.
template <std::size_t N>
std::array<double, N> normals(std::uint64_t key, std::uint32_t process, std::uint64_t sample) {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; i += 2) {
    const ComplexDraw draw =
        complex_normal(key, process, sample, static_cast<std::uint32_t>(i / 2));
    values[i] = std::sqrt(2.0) * draw.re;
    if (i + 1 < N) values[i + 1] = std::sqrt(2.0) * draw.im;
  }
  return values;
}

}  // namespace ensonify
