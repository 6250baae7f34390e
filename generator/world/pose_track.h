// The poses of a body over a short time, fast enough for millions of queries.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/vec.h"

namespace ensonify {

// Polynomials through poses, with as many pieces as their accuracy requires. Positions are within
// 1e-11 m of the body's own (or within 16 units in the last place, for far coordinates), and
// quaternions within 1e-13. Near a corner of the path, and beyond the span, the body's path itself
// is evaluated.
class PoseTrack {
 public:
  // The argument of `pose_at` is a time on the clock of `start_s`. The function is kept.
  PoseTrack(std::function<Pose(double)> pose_at, double start_s, double span_s);

  // The time counts from the start, which is 0.
  Pose at(double time_s) const;
  Vec3 position(double time_s) const;

  // The velocity of the body's origin, or of a point fixed to the body, by differences over 0.1 ms
  // on either side; at the start, only forward.
  Vec3 velocity(double time_s) const;
  Vec3 velocity(double time_s, Vec3 local_m) const;

  // Whether the body is at rest over the span.
  bool rests() const { return rests_; }

 private:
  static constexpr int kNodes = 8;
  using Values = std::array<double, 7>;  // x y z, quaternion w x y z

  struct Piece {
    double start_s = 0, end_s = 0;
    bool smooth = false;
    int terms = kNodes;  // of the polynomial; others are below the accuracy
    std::array<double, kNodes> node{};    // from -1 to 1
    std::array<Values, kNodes> newton{};  // divided differences
  };

  Pose exact(double time_s) const { return pose_at_(start_s_ + time_s); }
  // The nearest time that the clock can represent, because late times have coarser steps.
  double held(double time_s) const { return (start_s_ + time_s) - start_s_; }
  template <class Point>
  Vec3 velocity_of(const Point& point, double time_s) const;
  Values sample(double time_s) const;
  void add(double begin_s, double end_s, int depth);
  const Piece* piece_at(double time_s) const;  // null: evaluate the body's path

  std::function<Pose(double)> pose_at_;
  double start_s_ = 0, span_s_ = 0;
  Values first_{};
  bool rests_ = true;
  std::vector<Piece> pieces_;
};

}  // namespace ensonify
