// The poses of a body over a short time, fast enough for millions of queries.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/vec.h"

namespace ensonify {

// Polynomials through poses, as long as needed and as many: positions within 1e-11 m (or 16 units
// in the last place, of far coordinates), quaternions within 1e-13 of the body's own. Near a corner
// of the path, and beyond the span, it evaluates the body's path itself.
class PoseTrack {
 public:
  // `pose_at` by the clock in which `start_s` is; kept.
  PoseTrack(std::function<Pose(double)> pose_at, double start_s, double span_s);

  // Time counts from the start, from 0 on.
  Pose at(double time_s) const;
  Vec3 position(double time_s) const;

  // Of the body's origin, or of a point fixed to it, by differences over 0.1 ms to either side; at
  // the start ahead.
  Vec3 velocity(double time_s) const;
  Vec3 velocity(double time_s, Vec3 local_m) const;

  // Whether it stands still over the span.
  bool rests() const { return rests_; }

 private:
  static constexpr int kNodes = 8;
  using Values = std::array<double, 7>;  // x y z, quaternion w x y z

  struct Piece {
    double start_s = 0, end_s = 0;
    bool smooth = false;
    std::array<double, kNodes> node{};    // from -1 to 1
    std::array<Values, kNodes> newton{};  // divided differences
  };

  Pose exact(double time_s) const { return pose_at_(start_s_ + time_s); }
  // A time near this one that the clock can hold: late clocks count in steps.
  double held(double time_s) const { return (start_s_ + time_s) - start_s_; }
  template <class Point>
  Vec3 velocity_of(const Point& point, double time_s) const;
  Values sample(double time_s) const;
  void add(double begin_s, double end_s, int depth);
  const Piece* piece_at(double time_s) const;  // null: ask the body

  std::function<Pose(double)> pose_at_;
  double start_s_ = 0, span_s_ = 0;
  Values first_{};
  bool rests_ = true;
  std::vector<Piece> pieces_;
};

}  // namespace ensonify
