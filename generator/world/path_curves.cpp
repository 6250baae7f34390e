// Paths that are defined at every instant (lawnmower, orbit and spline), and the wave motion that
// is added to any path.
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/units.h"
#include "world/path.h"

namespace ensonify {
namespace {

// A line and the half circle after it.
double stride_m(const LawnmowerSpec& path) { return path.length_m + kPi * path.spacing_m / 2; }

double length_of(const LawnmowerSpec& path) {
  const double lines = line_count(path);
  return lines * path.length_m + (lines - 1) * kPi * path.spacing_m / 2;
}

double swept_rad(const OrbitSpec& path) { return 2 * kPi * path.turns; }

}  // namespace

// Rounding must not lose the fourth line at 1 m spacing in a width of 3 m.
double line_count(const LawnmowerSpec& path) {
  return std::floor(path.width_m / path.spacing_m * (1 + 1e-12)) + 1;
}

TimeSpan span_of(const LawnmowerSpec& path) {
  return {path.start_time_s, path.start_time_s + length_of(path) / path.speed_m_s};
}

Pose pose_at(const LawnmowerSpec& path, double time_s) {
  const double gone_m =
      std::clamp((time_s - path.start_time_s) * path.speed_m_s, 0.0, length_of(path));
  const double line = std::min(std::floor(gone_m / stride_m(path)), line_count(path) - 1);
  const double along_m = gone_m - line * stride_m(path);
  const bool back = std::fmod(line, 2) != 0;
  const double radius_m = path.spacing_m / 2;
  const double turned = along_m > path.length_m ? (along_m - path.length_m) / radius_m : 0;
  const double x = std::min(along_m, path.length_m) + radius_m * std::sin(turned);
  const double y = line * path.spacing_m + radius_m * (1 - std::cos(turned));
  // Both half circles lie to port of the first line: the body turns to starboard on the return
  // line.
  const double yaw = back ? kPi - turned : turned;
  const Pose first_line{{path.corner_m[0], path.corner_m[1], path.corner_m[2]},
                        from_roll_pitch_yaw(0, 0, radians(path.heading_deg))};
  return compose(first_line,
                 {{back ? path.length_m - x : x, y, 0}, from_roll_pitch_yaw(0, 0, yaw)});
}

TimeSpan span_of(const OrbitSpec& path) {
  return {path.start_time_s,
          path.start_time_s + std::abs(swept_rad(path)) * path.radius_m / path.speed_m_s};
}

Pose pose_at(const OrbitSpec& path, double time_s) {
  const double gone_rad = std::clamp((time_s - path.start_time_s) * path.speed_m_s / path.radius_m,
                                     0.0, std::abs(swept_rad(path)));
  const double bearing = radians(path.start_deg) + std::copysign(gone_rad, swept_rad(path));
  double yaw = bearing;
  if (path.look == OrbitLook::inward) yaw += kPi;
  if (path.look == OrbitLook::along) yaw += std::copysign(kPi / 2, swept_rad(path));
  const Vec3 center_m{path.center_m[0], path.center_m[1], path.center_m[2]};
  return {center_m + path.radius_m * Vec3{std::cos(bearing), std::sin(bearing), 0},
          from_roll_pitch_yaw(0, 0, yaw)};
}

namespace {

constexpr int kParts = SplineSegment::kParts;

Vec3 at(const SplineSegment& s, double u) { return s.a + u * (s.b + u * (s.c + u * s.d)); }
Vec3 slope(const SplineSegment& s, double u) { return s.b + u * (2.0 * s.c + 3 * u * s.d); }

// Gauss-Legendre with five nodes, which is exact to the ninth degree. The length of the slope is
// smooth.
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

// The parameter at which the arc length is `arc_m`, by Newton's method within the part.
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

// Roll stays zero. A vertical path has no heading; the world's x axis is used instead.
Quat facing(Vec3 direction) {
  const double level = std::hypot(direction.x, direction.y);
  const double yaw =
      level > 1e-9 * std::abs(direction.z) ? std::atan2(direction.y, direction.x) : 0;
  return from_roll_pitch_yaw(0, std::atan2(-direction.z, level), yaw);
}

double spline_length_m(const SplinePath& path) { return path.segments.back().arc_m.back(); }

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

SplinePath make_path(const SplineSpec& spec) {
  SplinePath path;
  path.speed_m_s = spec.speed_m_s;
  path.start_time_s = spec.start_time_s;
  if (const auto& look = spec.look_at_m) path.look_at_m = Vec3{(*look)[0], (*look)[1], (*look)[2]};
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
    path.segments.push_back(segment);
  }
  return path;
}

TimeSpan span_of(const SplinePath& path) {
  return {path.start_time_s, path.start_time_s + spline_length_m(path) / path.speed_m_s};
}

Pose pose_at(const SplinePath& path, double time_s) {
  const double arc_m =
      std::clamp((time_s - path.start_time_s) * path.speed_m_s, 0.0, spline_length_m(path));
  const auto after = std::upper_bound(
      path.segments.begin() + 1, path.segments.end(), arc_m,
      [](double wanted_m, const SplineSegment& segment) { return wanted_m < segment.arc_m[0]; });
  const SplineSegment& segment = *(after - 1);
  const double u = parameter_at(segment, arc_m);
  const Vec3 position = at(segment, u);
  return {position, facing(path.look_at_m ? *path.look_at_m - position : slope(segment, u))};
}

namespace {

constexpr double kCut = 3;  // standard deviations; no frequency reaches zero with bandwidth < 1/3

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Quantile of the normal density cut at +-kCut.
double cut_normal(double probability) {
  const double low_tail = normal_below(-kCut);
  const double wanted = low_tail + probability * (1 - 2 * low_tail);
  // The curvature does not change its sign on either side of zero, so that Newton's method never
  // overshoots.
  double z = 0;
  for (int i = 0; i < 12; ++i) {
    z += (wanted - normal_below(z)) * std::sqrt(2 * kPi) * std::exp(0.5 * z * z);
  }
  return std::clamp(z, -kCut, kCut);
}

WaveMotion::Axis make_axis(const WaveMotionSpec& spec, double rms, std::uint64_t key,
                           std::uint32_t axis) {
  WaveMotion::Axis made;
  made.rms = rms;
  if (rms == 0) return made;
  for (int i = 0; i < WaveMotion::kTerms; ++i) {
    const Philox4 words = random_words(key, axis, static_cast<std::uint64_t>(i), 0);
    const double stratum = (i + uniform_from_word(words.v[0])) / WaveMotion::kTerms;
    made.terms[i] = {2 * kPi / spec.period_s * (1 + spec.bandwidth * cut_normal(stratum)),
                     2 * kPi * uniform_from_word(words.v[1])};
  }
  return made;
}

double value_of(const WaveMotion::Axis& axis, double time_s) {
  if (axis.rms == 0) return 0;
  double sum = 0;
  for (const WaveMotion::Sinusoid& term : axis.terms)
    sum += std::cos(term.rad_s * time_s + term.phase_rad);
  return axis.rms * std::sqrt(2.0 / WaveMotion::kTerms) * sum;
}

}  // namespace

WaveMotion make_wave_motion(const WaveMotionSpec& spec, std::uint64_t key, double start_time_s) {
  return {start_time_s, make_axis(spec, radians(spec.roll_deg), key, 0),
          make_axis(spec, radians(spec.pitch_deg), key, 1),
          make_axis(spec, radians(spec.yaw_deg), key, 2), make_axis(spec, spec.heave_m, key, 3)};
}

Pose moved_by_waves(const WaveMotion& motion, double time_s, const Pose& pose) {
  const double t = time_s - motion.start_time_s;
  const Quat turn = from_roll_pitch_yaw(value_of(motion.roll, t), value_of(motion.pitch, t),
                                        value_of(motion.yaw, t));
  return {pose.position_m + Vec3{0, 0, value_of(motion.heave, t)}, pose.rotation * turn};
}

}  // namespace ensonify
