#include "world/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ensonify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The stretch of a ray that lies inside a convex body, with the normals where it enters and leaves.
struct Stretch {
  SurfaceHit enter{-kInfinity, {}};
  SurfaceHit leave{kInfinity, {}};
};

// Cuts a stretch by the slab |axis . p| <= half.
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
  // Through the point of the ray nearest to the centre: no difference of large squares.
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

}  // namespace ensonify
