// Closed-form shapes, in double precision, each in its own frame, and the patches that surfaces are
// divided into.
//
//   BoxShape SphereShape CylinderShape PlaneShape
//   intersect     nearest hit of a ray
//   half_extents  of the bounding box around the origin
//   signed_distance_m  to the surface, negative inside solids
//   TrianglePatch RectanglePatch SpherePatch MantlePatch DiscPatch   of a surface, halved again and
//                 into patches of equal area
//   surface_patches   of a body
//   area_m2  halves_of  ball_of  point_of   of a patch
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "core/vec.h"

namespace ensonify {

// `inside` makes the box a room that is seen from inside; rays from outside pass through its walls.
struct BoxShape {
  Vec3 half_size_m;
  bool inside = false;
};
struct SphereShape {
  double radius_m = 0;
  bool inside = false;
};
// A cylinder with axis z, centered at the origin and closed by two discs.
struct CylinderShape {
  double radius_m = 0, half_height_m = 0;
};
// The infinite plane z = 0, which is visible from both sides.
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
// A solid is visible from outside and, for a sonar inside it, from inside.
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

// Exact on both sides. The inside of a body, the outside of a room and the space below a plane are
// solid.
double signed_distance_m(const BoxShape& box, Vec3 p);
double signed_distance_m(const SphereShape& sphere, Vec3 p);
double signed_distance_m(const CylinderShape& cylinder, Vec3 p);
double signed_distance_m(const PlaneShape& plane, Vec3 p);

struct TrianglePatch {
  Vec3 a, b, c;
};
// corner + u [0, 1] + v [0, 1], u and v at right angles.
struct RectanglePatch {
  Vec3 corner, u, v;
};
struct Interval {
  double low = 0, high = 0;
  double length() const { return high - low; }
  double middle() const { return (low + high) / 2; }
  double at(double part) const { return low + part * (high - low); }
};
// The part of a sphere between two meridians and two heights; its area is radius . azimuth .
// height.
struct SpherePatch {
  double radius_m = 0;
  Interval azimuth_rad, z_m;
};
// The side of a cylinder.
struct MantlePatch {
  double radius_m = 0;
  Interval azimuth_rad, z_m;
};
// The part of a disc between two meridians and two circles.
struct DiscPatch {
  double z_m = 0;
  Interval azimuth_rad, radius_squared_m2;
};
using Patch = std::variant<TrianglePatch, RectanglePatch, SpherePatch, MantlePatch, DiscPatch>;

// The whole surface of a body in its own frame. A box has the faces -x, +x, -y, +y, -z, +z; a
// sphere has one patch; a cylinder has the mantle, the low disc and the high disc.
std::vector<Patch> surface_patches(const BoxShape& box);
std::vector<Patch> surface_patches(const SphereShape& sphere);
std::vector<Patch> surface_patches(const CylinderShape& cylinder);

double area_m2(const TrianglePatch& patch);
double area_m2(const RectanglePatch& patch);
double area_m2(const SpherePatch& patch);
double area_m2(const MantlePatch& patch);
double area_m2(const DiscPatch& patch);

// A patch is cut across its longer side, and a triangle from the middle of its longest edge.
std::array<TrianglePatch, 2> halves_of(const TrianglePatch& patch);
std::array<RectanglePatch, 2> halves_of(const RectanglePatch& patch);
std::array<SpherePatch, 2> halves_of(const SpherePatch& patch);
std::array<MantlePatch, 2> halves_of(const MantlePatch& patch);
std::array<DiscPatch, 2> halves_of(const DiscPatch& patch);

// A ball that contains the patch, but not the smallest one.
struct Ball {
  Vec3 centre_m;
  double radius_m = 0;
};
Ball ball_of(const TrianglePatch& patch);
Ball ball_of(const RectanglePatch& patch);
Ball ball_of(const SpherePatch& patch);
Ball ball_of(const MantlePatch& patch);
Ball ball_of(const DiscPatch& patch);

// A point of the patch, uniform over its area where u and v are uniform in (0, 1).
struct PatchPoint {
  Vec3 position_m;
  Vec3 normal;  // unit length, of either sign
};
PatchPoint point_of(const TrianglePatch& patch, double u, double v);
PatchPoint point_of(const RectanglePatch& patch, double u, double v);
PatchPoint point_of(const SpherePatch& patch, double u, double v);
PatchPoint point_of(const MantlePatch& patch, double u, double v);
PatchPoint point_of(const DiscPatch& patch, double u, double v);

}  // namespace ensonify
