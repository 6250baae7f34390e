// Vectors, rotations and rigid poses, in double precision.
//
//   Vec3   dot cross length normalized
//   Quat   from_roll_pitch_yaw rotate conjugate slerp
//   Pose   transform_point inverse_transform_point compose
//
// Frames: world x east, y north, z up; sonar x along the boresight, y to port, z up.
#pragma once

#include <cmath>

#include "core/compile_targets.h"

namespace ensonify {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

ENSONIFY_HD inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
ENSONIFY_HD inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
ENSONIFY_HD inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
ENSONIFY_HD inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
ENSONIFY_HD inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ENSONIFY_HD inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
ENSONIFY_HD inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }

// a / |a|; NaN for the zero vector, which the caller excludes.
ENSONIFY_HD inline Vec3 normalized(Vec3 a) { return (1.0 / length(a)) * a; }

// Unit quaternion of a rotation, w first.
struct Quat {
  double w = 1, x = 0, y = 0, z = 0;
  friend bool operator==(const Quat&, const Quat&) = default;
};

ENSONIFY_HD inline Quat operator*(Quat a, Quat b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
ENSONIFY_HD inline Quat conjugate(Quat q) { return {q.w, -q.x, -q.y, -q.z}; }

ENSONIFY_HD inline Vec3 rotate(Quat q, Vec3 v) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

// Scales to unit length; NaN for the zero quaternion, which the caller excludes.
inline Quat normalized(Quat q) {
  const double s = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

// Intrinsic z-y'-x'' rotation (ROS convention): yaw, then pitch, then roll, in radians.
// Positive pitch is nose down.
Quat from_roll_pitch_yaw(double roll_rad, double pitch_rad, double yaw_rad);

// Shortest-arc spherical interpolation from a (u = 0) to b (u = 1).
Quat slerp(Quat a, Quat b, double u);

// Places a frame in its parent: p_parent = rotation * p + position.
struct Pose {
  Vec3 position_m;
  Quat rotation;
  friend bool operator==(const Pose&, const Pose&) = default;
};

ENSONIFY_HD inline Vec3 transform_point(const Pose& pose, Vec3 p) {
  return rotate(pose.rotation, p) + pose.position_m;
}
ENSONIFY_HD inline Vec3 inverse_transform_point(const Pose& pose, Vec3 p) {
  return rotate(conjugate(pose.rotation), p - pose.position_m);
}

// The pose of a frame given in `child`, which is itself placed by `parent`.
ENSONIFY_HD inline Pose compose(const Pose& parent, const Pose& child) {
  return {transform_point(parent, child.position_m), parent.rotation * child.rotation};
}

}  // namespace ensonify
