#include "world/pose_track.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kPosition_m = 1e-11, kQuaternion = 1e-13;
constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
constexpr int kMostCuts = 10;
constexpr double kVelocityStep_s = 1e-4;

Pose pose_of(const std::array<double, 7>& v) {
  return {{v[0], v[1], v[2]}, normalized(Quat{v[3], v[4], v[5], v[6]})};
}

}  // namespace

PoseTrack::PoseTrack(std::function<Pose(double)> pose_at, double start_s, double span_s)
    : pose_at_(std::move(pose_at)), start_s_(start_s), span_s_(span_s) {
  const Pose pose = exact(0);
  const Quat& q = pose.rotation;
  first_ = {pose.position_m.x, pose.position_m.y, pose.position_m.z, q.w, q.x, q.y, q.z};
  add(0, span_s, 0);
}

// q and -q are the same rotation. The one nearer to the first quaternion is used.
PoseTrack::Values PoseTrack::sample(double time_s) const {
  const Pose pose = exact(time_s);
  const Vec3& p = pose.position_m;
  const Quat& q = pose.rotation;
  const double same = q.w * first_[3] + q.x * first_[4] + q.y * first_[5] + q.z * first_[6];
  const double sign = same < 0 ? -1 : 1;
  return {p.x, p.y, p.z, sign * q.w, sign * q.x, sign * q.y, sign * q.z};
}

namespace {

template <std::size_t Nodes, std::size_t Count>
void divide_differences(const std::array<double, Nodes>& node,
                        std::array<std::array<double, Count>, Nodes>& value) {
  for (std::size_t order = 1; order < Nodes; ++order) {
    for (std::size_t i = Nodes - 1; i >= order; --i) {
      for (std::size_t c = 0; c < Count; ++c) {
        value[i][c] = (value[i][c] - value[i - 1][c]) / (node[i] - node[i - order]);
      }
    }
  }
}

// The first `Parts` components of the polynomial with `terms` terms at x.
template <std::size_t Parts, std::size_t Nodes, std::size_t Count>
std::array<double, Parts> evaluate(const std::array<double, Nodes>& node,
                                   const std::array<std::array<double, Count>, Nodes>& newton,
                                   int terms, double x) {
  std::array<double, Parts> result;
  const auto last = static_cast<std::size_t>(terms - 1);
  for (std::size_t c = 0; c < Parts; ++c) result[c] = newton[last][c];
  for (std::size_t i = last; i-- > 0;) {
    for (std::size_t c = 0; c < Parts; ++c) result[c] = result[c] * (x - node[i]) + newton[i][c];
  }
  return result;
}

// The terms of a polynomial that count. Products of (x - node) are below 8, so that what is left
// out stays far below the accuracy of a track.
template <std::size_t Nodes>
int terms_of(const std::array<std::array<double, 7>, Nodes>& newton) {
  constexpr double kLeast = 1e-3;
  int terms = static_cast<int>(Nodes);
  const auto counts = [&](const std::array<double, 7>& term) {
    for (int c = 0; c < 7; ++c) {
      if (std::abs(term[c]) > kLeast * (c < 3 ? kPosition_m : kQuaternion)) return true;
    }
    return false;
  };
  while (terms > 1 && !counts(newton[terms - 1])) --terms;
  return terms;
}

double in_piece(double time_s, double begin_s, double end_s) {
  return (2 * time_s - begin_s - end_s) / (end_s - begin_s);
}

}  // namespace

void PoseTrack::add(double begin_s, double end_s, int depth) {
  Piece piece{begin_s, end_s, true, kNodes, {}, {}};
  const auto chebyshev = [&](double i) {
    const double x = -std::cos(kPi * i / (kNodes - 1));
    return held(begin_s + (end_s - begin_s) * (1 + x) / 2);
  };
  for (int i = 0; i < kNodes; ++i) {
    const double time = chebyshev(i);
    piece.node[i] = in_piece(time, begin_s, end_s);
    piece.newton[i] = sample(time);
    if (i > 0 && piece.node[i] <= piece.node[i - 1]) piece.smooth = false;  // the clock's steps
    rests_ = rests_ && piece.newton[i] == first_;
  }
  if (piece.smooth) {
    divide_differences(piece.node, piece.newton);
    piece.terms = terms_of(piece.newton);
  }
  for (int i = 0; i + 1 < kNodes && piece.smooth; ++i) {
    const double time = chebyshev(i + 0.5);
    const Values right = sample(time);
    rests_ = rests_ && right == first_;
    const auto got =
        evaluate<7>(piece.node, piece.newton, piece.terms, in_piece(time, begin_s, end_s));
    for (int c = 0; c < 7; ++c) {
      const double allowed =
          c < 3 ? std::max(kPosition_m, kRounding * std::abs(right[c])) : kQuaternion;
      piece.smooth = piece.smooth && std::abs(got[c] - right[c]) <= allowed;
    }
  }
  if (piece.smooth || depth == kMostCuts) {
    pieces_.push_back(piece);
    return;
  }
  const double middle = (begin_s + end_s) / 2;
  add(begin_s, middle, depth + 1);
  add(middle, end_s, depth + 1);
}

const PoseTrack::Piece* PoseTrack::piece_at(double time_s) const {
  if (!(time_s >= 0 && time_s <= span_s_)) return nullptr;
  const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), time_s,
                                      [](double t, const Piece& p) { return t < p.start_s; });
  const Piece& piece = *(after - 1);
  return piece.smooth ? &piece : nullptr;
}

Pose PoseTrack::at(double time_s) const {
  const Piece* piece = piece_at(time_s);
  if (piece == nullptr) return exact(time_s);
  return pose_of(evaluate<7>(piece->node, piece->newton, piece->terms,
                             in_piece(time_s, piece->start_s, piece->end_s)));
}

Vec3 PoseTrack::position(double time_s) const {
  const Piece* piece = piece_at(time_s);
  if (piece == nullptr) return exact(time_s).position_m;
  const auto [x, y, z] = evaluate<3>(piece->node, piece->newton, piece->terms,
                                     in_piece(time_s, piece->start_s, piece->end_s));
  return {x, y, z};
}

template <class Point>
Vec3 PoseTrack::velocity_of(const Point& point, double time_s) const {
  const double h = kVelocityStep_s;
  if (time_s >= h) {
    const double before = held(time_s - h), after = held(time_s + h);
    return (1 / (after - before)) * (point(after) - point(before));
  }
  // A one-sided difference, also of second order.
  const double t0 = held(time_s), t1 = held(time_s + h), t2 = held(time_s + 2 * h);
  const Vec3 near = (1 / (t1 - t0)) * (point(t1) - point(t0));
  const Vec3 far = (1 / (t2 - t1)) * (point(t2) - point(t1));
  return near - ((t1 - t0) / (t2 - t0)) * (far - near);
}

Vec3 PoseTrack::velocity(double time_s) const {
  return velocity_of([&](double t) { return position(t); }, time_s);
}

Vec3 PoseTrack::velocity(double time_s, Vec3 local_m) const {
  return velocity_of([&](double t) { return transform_point(at(t), local_m); }, time_s);
}

}  // namespace ensonify
