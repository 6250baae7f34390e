// Pieces of a surface that can be halved again and again, all halves of equal area, in the frame of
// their shape.
//
//   TrianglePatch RectanglePatch SpherePatch MantlePatch DiscPatch
//   area_m2  halves_of  ball_of  point_of   of one
//   Ball
#pragma once

#include <array>
#include <variant>

#include "core/vec.h"

namespace ensonify {

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
// Between two meridians and two heights: its area is radius . azimuth . height.
struct SpherePatch {
  double radius_m = 0;
  Interval azimuth_rad, z_m;
};
// The side of a cylinder.
struct MantlePatch {
  double radius_m = 0;
  Interval azimuth_rad, z_m;
};
// Between two meridians and two circles.
struct DiscPatch {
  double z_m = 0;
  Interval azimuth_rad, radius_squared_m2;
};
using Patch = std::variant<TrianglePatch, RectanglePatch, SpherePatch, MantlePatch, DiscPatch>;

double area_m2(const TrianglePatch& patch);
double area_m2(const RectanglePatch& patch);
double area_m2(const SpherePatch& patch);
double area_m2(const MantlePatch& patch);
double area_m2(const DiscPatch& patch);

// Cut across the longer side; a triangle from the middle of its longest edge.
std::array<TrianglePatch, 2> halves_of(const TrianglePatch& patch);
std::array<RectanglePatch, 2> halves_of(const RectanglePatch& patch);
std::array<SpherePatch, 2> halves_of(const SpherePatch& patch);
std::array<MantlePatch, 2> halves_of(const MantlePatch& patch);
std::array<DiscPatch, 2> halves_of(const DiscPatch& patch);

// Holds the patch; not the smallest one.
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
