// Closed-form shapes, in double precision, each in its own frame.
//
//   BoxShape SphereShape CylinderShape PlaneShape
//   intersect     nearest hit of a ray
//   half_extents  of the bounding box around the origin
//   signed_distance_m  from the surface, negative in what is solid
#pragma once

#include <optional>
#include <variant>

#include "core/vec.h"

namespace ensonify {

// `inside`: a room, seen from within; rays pass its walls from outside.
struct BoxShape {
  Vec3 half_size_m;
  bool inside = false;
};
struct SphereShape {
  double radius_m = 0;
  bool inside = false;
};
// Axis z, centred at the origin, closed by two discs.
struct CylinderShape {
  double radius_m = 0, half_height_m = 0;
};
// z = 0, without end, seen from both sides.
struct PlaneShape {};

struct Ray {
  Vec3 origin_m;
  Vec3 direction;  // unit length
};

struct SurfaceHit {
  double range_m = 0;
  Vec3 normal;  // unit length, of either sign
};

// The nearest hit beyond `nearest_m` (>= 0); none for a ray that misses or runs along the surface.
// A solid is seen from outside and, by a sonar that stands in it, from within.
std::optional<SurfaceHit> intersect(const BoxShape& box, const Ray& ray, double nearest_m);
std::optional<SurfaceHit> intersect(const SphereShape& sphere, const Ray& ray, double nearest_m);
std::optional<SurfaceHit> intersect(const CylinderShape& cylinder, const Ray& ray,
                                    double nearest_m);
std::optional<SurfaceHit> intersect(const PlaneShape& plane, const Ray& ray, double nearest_m);

inline Vec3 half_extents(const BoxShape& box) { return box.half_size_m; }
inline Vec3 half_extents(const SphereShape& s) { return {s.radius_m, s.radius_m, s.radius_m}; }
inline Vec3 half_extents(const CylinderShape& c) {
  return {c.radius_m, c.radius_m, c.half_height_m};
}

// Exact on both sides. Solid is the inside of a body, the outside of a room and what is below a
// plane.
double signed_distance_m(const BoxShape& box, Vec3 p);
double signed_distance_m(const SphereShape& sphere, Vec3 p);
double signed_distance_m(const CylinderShape& cylinder, Vec3 p);
double signed_distance_m(const PlaneShape& plane, Vec3 p);

}  // namespace ensonify
