#include "world/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The segment of a ray inside a convex body, with the normals where it enters and leaves.
struct Stretch {
  SurfaceHit enter{-kInfinity, {}};
  SurfaceHit leave{kInfinity, {}};
};

// Clips a segment to the slab |axis . p| <= half.
void cut_by_slab(Stretch& stretch, double origin, double direction, double half, Vec3 axis) {
  if (direction == 0) {
    if (std::abs(origin) > half) stretch.enter.range_m = kInfinity;
    return;
  }
  const double sign = direction > 0 ? 1 : -1;
  const double enter = (-sign * half - origin) / direction;
  const double leave = (sign * half - origin) / direction;
  if (enter > stretch.enter.range_m) stretch.enter = {enter, -sign * axis};
  if (leave < stretch.leave.range_m) stretch.leave = {leave, sign * axis};
}

std::optional<SurfaceHit> choose(const Stretch& stretch, bool inside, double nearest_m) {
  if (!(stretch.enter.range_m < stretch.leave.range_m)) return std::nullopt;
  if (!inside && stretch.enter.range_m > nearest_m) return stretch.enter;
  if (stretch.leave.range_m > nearest_m && std::isfinite(stretch.leave.range_m)) {
    return stretch.leave;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SurfaceHit> intersect(const BoxShape& box, const Ray& ray, double nearest_m) {
  Stretch stretch;
  cut_by_slab(stretch, ray.origin_m.x, ray.direction.x, box.half_size_m.x, {1, 0, 0});
  cut_by_slab(stretch, ray.origin_m.y, ray.direction.y, box.half_size_m.y, {0, 1, 0});
  cut_by_slab(stretch, ray.origin_m.z, ray.direction.z, box.half_size_m.z, {0, 0, 1});
  return choose(stretch, box.inside, nearest_m);
}

std::optional<SurfaceHit> intersect(const SphereShape& sphere, const Ray& ray, double nearest_m) {
  // Starts from the point of the ray nearest to the center, which avoids a difference of large
  // squares.
  const double middle = -dot(ray.origin_m, ray.direction);
  const Vec3 closest = ray.origin_m + middle * ray.direction;
  const double square = sphere.radius_m * sphere.radius_m - dot(closest, closest);
  if (!(square > 0)) return std::nullopt;
  const double half_chord = std::sqrt(square);
  Stretch stretch;
  stretch.enter.range_m = middle - half_chord;
  stretch.leave.range_m = middle + half_chord;
  std::optional<SurfaceHit> hit = choose(stretch, sphere.inside, nearest_m);
  if (hit) hit->normal = normalized(ray.origin_m + hit->range_m * ray.direction);
  return hit;
}

std::optional<SurfaceHit> intersect(const CylinderShape& cylinder, const Ray& ray,
                                    double nearest_m) {
  Stretch stretch;
  cut_by_slab(stretch, ray.origin_m.z, ray.direction.z, cylinder.half_height_m, {0, 0, 1});
  const Vec3 o{ray.origin_m.x, ray.origin_m.y, 0};
  const Vec3 d{ray.direction.x, ray.direction.y, 0};
  const double a = dot(d, d);
  const double radius2 = cylinder.radius_m * cylinder.radius_m;
  if (a == 0) {
    if (dot(o, o) > radius2) return std::nullopt;
    return choose(stretch, false, nearest_m);
  }
  const double middle = -dot(o, d) / a;
  const Vec3 closest = o + middle * d;
  const double square = radius2 - dot(closest, closest);
  if (!(square > 0)) return std::nullopt;
  const double half_chord = std::sqrt(square / a);
  const auto side_normal = [&](double t) { return (1.0 / cylinder.radius_m) * (o + t * d); };
  if (middle - half_chord > stretch.enter.range_m) {
    stretch.enter = {middle - half_chord, side_normal(middle - half_chord)};
  }
  if (middle + half_chord < stretch.leave.range_m) {
    stretch.leave = {middle + half_chord, side_normal(middle + half_chord)};
  }
  return choose(stretch, false, nearest_m);
}

std::optional<SurfaceHit> intersect(const PlaneShape&, const Ray& ray, double nearest_m) {
  if (ray.direction.z == 0) return std::nullopt;
  const double range = -ray.origin_m.z / ray.direction.z;
  if (!(range > nearest_m) || !std::isfinite(range)) return std::nullopt;
  return SurfaceHit{range, {0, 0, 1}};
}

double signed_distance_m(const BoxShape& box, Vec3 p) {
  const Vec3 q{std::abs(p.x) - box.half_size_m.x, std::abs(p.y) - box.half_size_m.y,
               std::abs(p.z) - box.half_size_m.z};
  const Vec3 outside{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
  const double distance = length(outside) + std::min(std::max({q.x, q.y, q.z}), 0.0);
  return box.inside ? -distance : distance;
}

double signed_distance_m(const SphereShape& sphere, Vec3 p) {
  const double distance = length(p) - sphere.radius_m;
  return sphere.inside ? -distance : distance;
}

double signed_distance_m(const CylinderShape& cylinder, Vec3 p) {
  const double side = std::hypot(p.x, p.y) - cylinder.radius_m;
  const double end = std::abs(p.z) - cylinder.half_height_m;
  return std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
}

double signed_distance_m(const PlaneShape&, Vec3 p) { return p.z; }

namespace {

std::array<Interval, 2> halves_of(Interval span) {
  const double middle = span.middle();
  return {{{span.low, middle}, {middle, span.high}}};
}

// The radius of the sphere's circle at a height.
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

// Two halves, cut at the middle of one of the patch's sides.
template <class P>
std::array<P, 2> cut_along(const P& patch, Interval P::*side) {
  std::array<P, 2> halves{patch, patch};
  const auto spans = halves_of(patch.*side);
  for (int i = 0; i < 2; ++i) halves[i].*side = spans[i];
  return halves;
}

}  // namespace

std::vector<Patch> surface_patches(const BoxShape& box) {
  const Vec3 h = box.half_size_m;
  const Vec3 x{2 * h.x, 0, 0}, y{0, 2 * h.y, 0}, z{0, 0, 2 * h.z};
  const Vec3 low = -h;
  return {RectanglePatch{low, y, z}, RectanglePatch{low + x, y, z},
          RectanglePatch{low, z, x}, RectanglePatch{low + y, z, x},
          RectanglePatch{low, x, y}, RectanglePatch{low + z, x, y}};
}

std::vector<Patch> surface_patches(const SphereShape& s) {
  return {SpherePatch{s.radius_m, {-kPi, kPi}, {-s.radius_m, s.radius_m}}};
}

std::vector<Patch> surface_patches(const CylinderShape& c) {
  const Interval whole{0, c.radius_m * c.radius_m};
  return {MantlePatch{c.radius_m, {-kPi, kPi}, {-c.half_height_m, c.half_height_m}},
          DiscPatch{-c.half_height_m, {-kPi, kPi}, whole},
          DiscPatch{c.half_height_m, {-kPi, kPi}, whole}};
}

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
  // The triangle is turned so that its longest edge is from a to b.
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

// On a curved patch, a path along the meridian and then around the axis reaches any point.
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
  // Folds the far half of the parallelogram back.
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
