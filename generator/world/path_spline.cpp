#include <algorithm>
#include <cmath>

#include "world/path_ways.h"

namespace ensonify {
namespace {

constexpr int kParts = SplineSegment::kParts;

Vec3 at(const SplineSegment& s, double u) { return s.a + u * (s.b + u * (s.c + u * s.d)); }
Vec3 slope(const SplineSegment& s, double u) { return s.b + u * (2.0 * s.c + 3 * u * s.d); }

// Gauss-Legendre with five nodes: exact to the ninth degree, and the slope's length is smooth.
double arc_between(const SplineSegment& s, double u0, double u1) {
  constexpr double kNode[] = {0, 0.5384693101056831, 0.9061798459386640};
  constexpr double kWeight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double middle = 0.5 * (u0 + u1), half = 0.5 * (u1 - u0);
  double sum = kWeight[0] * length(slope(s, middle));
  for (int i = 1; i < 3; ++i) {
    sum += kWeight[i] * (length(slope(s, middle + half * kNode[i])) +
                         length(slope(s, middle - half * kNode[i])));
  }
  return half * sum;
}

// The parameter where the arc length reaches `arc_m`, by Newton's rule held within the part.
double parameter_at(const SplineSegment& s, double arc_m) {
  const auto after = std::upper_bound(s.arc_m.begin() + 1, s.arc_m.end() - 1, arc_m);
  const auto part = static_cast<int>(after - s.arc_m.begin()) - 1;
  const double u0 = static_cast<double>(part) / kParts;
  const double wanted_m = std::max(0.0, arc_m - s.arc_m[part]);
  double low = u0, high = (part + 1.0) / kParts;
  double u = low + (high - low) * std::min(1.0, wanted_m / (s.arc_m[part + 1] - s.arc_m[part]));
  for (int i = 0; i < 50; ++i) {
    const double excess_m = arc_between(s, u0, u) - wanted_m;
    (excess_m > 0 ? high : low) = u;
    double next = u - excess_m / length(slope(s, u));
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::abs(next - u) < 1e-15) break;
    u = next;
  }
  return u;
}

// Roll stays zero. Straight up or down has no heading: it is then the world's x.
Quat facing(Vec3 direction) {
  const double level = std::hypot(direction.x, direction.y);
  const double yaw =
      level > 1e-9 * std::abs(direction.z) ? std::atan2(direction.y, direction.x) : 0;
  return from_roll_pitch_yaw(0, std::atan2(-direction.z, level), yaw);
}

double spline_length_m(const SplineWay& way) { return way.segments.back().arc_m.back(); }

// The cubic from p1 to p2 whose slopes there are those of the centripetal spline: its knots lie
// the square root of the distance apart.
SplineSegment segment_between(Vec3 p0, Vec3 p1, Vec3 p2, Vec3 p3) {
  const double d01 = std::sqrt(length(p1 - p0)), d12 = std::sqrt(length(p2 - p1)),
               d23 = std::sqrt(length(p3 - p2));
  const Vec3 chord = p2 - p1;
  const Vec3 first = chord + d12 * ((1 / d01) * (p1 - p0) - (1 / (d01 + d12)) * (p2 - p0));
  const Vec3 last = chord + d12 * ((1 / d23) * (p3 - p2) - (1 / (d12 + d23)) * (p3 - p1));
  return {p1, first, 3.0 * chord - 2.0 * first - last, first + last - 2.0 * chord, {}};
}

}  // namespace

SplineWay make_way(const SplineSpec& spec) {
  SplineWay way;
  way.speed_m_s = spec.speed_m_s;
  way.start_time_s = spec.start_time_s;
  if (const auto& look = spec.look_at_m) way.look_at_m = Vec3{(*look)[0], (*look)[1], (*look)[2]};
  std::vector<Vec3> points(1);
  for (const auto& p : spec.points_m) points.push_back({p[0], p[1], p[2]});
  const std::size_t last = points.size() - 1;
  points[0] = 2.0 * points[1] - points[2];
  points.push_back(2.0 * points[last] - points[last - 1]);
  double arc_m = 0;
  for (std::size_t i = 1; i < last; ++i) {
    SplineSegment segment = segment_between(points[i - 1], points[i], points[i + 1], points[i + 2]);
    segment.arc_m[0] = arc_m;
    for (int k = 0; k < kParts; ++k) {
      arc_m += arc_between(segment, static_cast<double>(k) / kParts, (k + 1.0) / kParts);
      segment.arc_m[k + 1] = arc_m;
    }
    way.segments.push_back(segment);
  }
  return way;
}

TimeSpan span_of(const SplineWay& way) {
  return {way.start_time_s, way.start_time_s + spline_length_m(way) / way.speed_m_s};
}

Pose pose_on(const SplineWay& way, double time_s) {
  const double arc_m =
      std::clamp((time_s - way.start_time_s) * way.speed_m_s, 0.0, spline_length_m(way));
  const auto after = std::upper_bound(
      way.segments.begin() + 1, way.segments.end(), arc_m,
      [](double wanted_m, const SplineSegment& segment) { return wanted_m < segment.arc_m[0]; });
  const SplineSegment& segment = *(after - 1);
  const double u = parameter_at(segment, arc_m);
  const Vec3 position = at(segment, u);
  return {position, facing(way.look_at_m ? *way.look_at_m - position : slope(segment, u))};
}

}  // namespace ensonify
