#include "world/patch.h"

#include <algorithm>
#include <cmath>

namespace ensonify {
namespace {

std::array<Interval, 2> halves_of(Interval span) {
  const double middle = span.middle();
  return {{{span.low, middle}, {middle, span.high}}};
}

// Of a point on the sphere at that height.
double circle_radius(double radius_m, double z_m) {
  return std::sqrt(std::max(0.0, (radius_m - z_m) * (radius_m + z_m)));
}

// The longest circle of a sphere's patch.
double widest_circle(const SpherePatch& patch) {
  const Interval z = patch.z_m;
  if (z.low <= 0 && z.high >= 0) return patch.radius_m;
  return circle_radius(patch.radius_m, std::min(std::abs(z.low), std::abs(z.high)));
}

// Along the meridian.
double distance_m(const SpherePatch& patch, double low_m, double high_m) {
  const auto latitude = [&](double z) {
    return std::asin(std::clamp(z / patch.radius_m, -1.0, 1.0));
  };
  return patch.radius_m * (latitude(high_m) - latitude(low_m));
}

// Two halves in the middle of one of the patch's sides.
template <class P>
std::array<P, 2> cut_along(const P& patch, Interval P::*side) {
  std::array<P, 2> halves{patch, patch};
  const auto spans = halves_of(patch.*side);
  for (int i = 0; i < 2; ++i) halves[i].*side = spans[i];
  return halves;
}

}  // namespace

double area_m2(const TrianglePatch& t) { return length(cross(t.b - t.a, t.c - t.a)) / 2; }
double area_m2(const RectanglePatch& r) { return length(r.u) * length(r.v); }
double area_m2(const SpherePatch& s) {
  return s.radius_m * s.azimuth_rad.length() * s.z_m.length();
}
double area_m2(const MantlePatch& m) {
  return m.radius_m * m.azimuth_rad.length() * m.z_m.length();
}
double area_m2(const DiscPatch& d) {
  return d.azimuth_rad.length() * d.radius_squared_m2.length() / 2;
}

std::array<TrianglePatch, 2> halves_of(const TrianglePatch& t) {
  const auto squared = [](Vec3 edge) { return dot(edge, edge); };
  const double ab = squared(t.b - t.a), bc = squared(t.c - t.b), ca = squared(t.a - t.c);
  // Turned so that the longest edge is a to b.
  TrianglePatch turned = t;
  if (bc > ab && bc >= ca) {
    turned = {t.b, t.c, t.a};
  } else if (ca > ab) {
    turned = {t.c, t.a, t.b};
  }
  const Vec3 middle = 0.5 * (turned.a + turned.b);
  return {{{turned.c, turned.a, middle}, {turned.b, turned.c, middle}}};
}

std::array<RectanglePatch, 2> halves_of(const RectanglePatch& r) {
  if (dot(r.u, r.u) >= dot(r.v, r.v)) {
    const Vec3 half = 0.5 * r.u;
    return {{{r.corner, half, r.v}, {r.corner + half, half, r.v}}};
  }
  const Vec3 half = 0.5 * r.v;
  return {{{r.corner, r.u, half}, {r.corner + half, r.u, half}}};
}

std::array<SpherePatch, 2> halves_of(const SpherePatch& s) {
  const double high = distance_m(s, s.z_m.low, s.z_m.high);
  const bool is_wide = widest_circle(s) * s.azimuth_rad.length() >= high;
  return cut_along(s, is_wide ? &SpherePatch::azimuth_rad : &SpherePatch::z_m);
}

std::array<MantlePatch, 2> halves_of(const MantlePatch& m) {
  const bool is_wide = m.radius_m * m.azimuth_rad.length() >= m.z_m.length();
  return cut_along(m, is_wide ? &MantlePatch::azimuth_rad : &MantlePatch::z_m);
}

std::array<DiscPatch, 2> halves_of(const DiscPatch& d) {
  const double inner = std::sqrt(d.radius_squared_m2.low);
  const double outer = std::sqrt(d.radius_squared_m2.high);
  const bool is_wide = (inner + outer) / 2 * d.azimuth_rad.length() >= outer - inner;
  return cut_along(d, is_wide ? &DiscPatch::azimuth_rad : &DiscPatch::radius_squared_m2);
}

Ball ball_of(const TrianglePatch& t) {
  const Vec3 centre = (1.0 / 3) * (t.a + t.b + t.c);
  return {centre, std::max({length(t.a - centre), length(t.b - centre), length(t.c - centre)})};
}

Ball ball_of(const RectanglePatch& r) {
  return {r.corner + 0.5 * (r.u + r.v), 0.5 * length(r.u + r.v)};
}

// On curved ones any point is reached along the meridian and then around.
Ball ball_of(const SpherePatch& s) {
  const double middle = s.z_m.middle();
  const double reach =
      widest_circle(s) * s.azimuth_rad.length() / 2 +
      std::max(distance_m(s, s.z_m.low, middle), distance_m(s, middle, s.z_m.high));
  if (reach >= s.radius_m) return {{}, s.radius_m};
  return {point_of(s, 0.5, 0.5).position_m, reach};
}

Ball ball_of(const MantlePatch& m) {
  const double around = m.radius_m * m.azimuth_rad.length() / 2;
  if (around >= m.radius_m) {
    return {{0, 0, m.z_m.middle()}, std::hypot(m.radius_m, m.z_m.length() / 2)};
  }
  return {point_of(m, 0.5, 0.5).position_m, std::hypot(around, m.z_m.length() / 2)};
}

Ball ball_of(const DiscPatch& d) {
  const double inner = std::sqrt(d.radius_squared_m2.low);
  const double outer = std::sqrt(d.radius_squared_m2.high);
  const double middle = (inner + outer) / 2;
  const double reach = outer * d.azimuth_rad.length() / 2 + (outer - inner) / 2;
  if (reach >= outer) return {{0, 0, d.z_m}, outer};
  const double azimuth = d.azimuth_rad.middle();
  return {{middle * std::cos(azimuth), middle * std::sin(azimuth), d.z_m}, reach};
}

PatchPoint point_of(const TrianglePatch& t, double u, double v) {
  // The far half of the parallelogram folded back.
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Vec3 ab = t.b - t.a, ac = t.c - t.a;
  return {t.a + u * ab + v * ac, normalized(cross(ab, ac))};
}

PatchPoint point_of(const RectanglePatch& r, double u, double v) {
  return {r.corner + u * r.u + v * r.v, normalized(cross(r.u, r.v))};
}

PatchPoint point_of(const SpherePatch& s, double u, double v) {
  const double azimuth = s.azimuth_rad.at(u), z = s.z_m.at(v);
  const double across = circle_radius(s.radius_m, z);
  const Vec3 p{across * std::cos(azimuth), across * std::sin(azimuth), z};
  return {p, (1.0 / s.radius_m) * p};
}

PatchPoint point_of(const MantlePatch& m, double u, double v) {
  const double azimuth = m.azimuth_rad.at(u);
  const Vec3 normal{std::cos(azimuth), std::sin(azimuth), 0};
  return {m.radius_m * normal + Vec3{0, 0, m.z_m.at(v)}, normal};
}

PatchPoint point_of(const DiscPatch& d, double u, double v) {
  const double azimuth = d.azimuth_rad.at(u), radius = std::sqrt(d.radius_squared_m2.at(v));
  return {{radius * std::cos(azimuth), radius * std::sin(azimuth), d.z_m}, {0, 0, 1}};
}

}  // namespace ensonify
