// The extent of a body, and where it may touch the ground.
//
//   box_of                  3-D boxes for the labels
//   Outline  outline_of     a turned body seen from above, and its heights
//   turned                  an outline, about the vertical
//   Gap  gap_between        of two outlines, seen from above
//   contact_points          on its surface, in its own frame
//   support_point           the farthest one in a direction
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/ping.h"
#include "core/vec.h"
#include "world/volumes.h"
#include "world/world.h"

namespace ensonify {

// The box along the axes of the object's own frame; none for a plane. The box of a mesh encloses
// its vertices.
std::optional<OrientedBox> box_of(const Shape& shape);

// The box in the world. That of a school encloses its fish, along the world's axes; without fish
// there is none. That of a density grid encloses the bricks that have a density, and is too large
// by at most one brick of 8 samples on every side. An infinite density or an empty grid has none.
std::optional<OrientedBox> box_of(const Volume& volume);
std::optional<OrientedBox> box_of(const School& school);

// Relative to the body's origin, or to another point that moves with the body.
struct Outline {
  std::vector<std::array<double, 2>> hull_m;  // convex, counter-clockwise; one point of a circle
  double round_m = 0;                         // distance by which the body extends beyond the hull
  double x_m = 0, y_m = 0;                    // middle of the rectangle around it
  double radius_m = 0;                        // of the circle around that middle that encloses it
  double low_m = 0, high_m = 0;
};

// The outline of a box or mesh is the convex hull, and that of a sphere or upright cylinder is the
// circle. The outline of another cylinder is at most 0.5 % too wide. Must not be called for a
// plane, which has none.
Outline outline_of(const Shape& shape, const Quat& rotation);
Outline turned(const Outline& outline, double yaw_rad);
Outline moved(Outline outline, Vec3 by_m);

// The vector from one outline to the nearest point of another, of length `distance_m`. If the
// outlines overlap, the length is negative: the depth along the direction in which it is least.
struct Gap {
  double distance_m = 0;
  double x = 0, y = 0;  // unit length
};
Gap gap_between(const Outline& from, const Outline& to);

// All vertices of a mesh, and sufficiently dense points on other shapes: 150 of a box, 225 of a
// cylinder, 200 of a sphere.
std::vector<Vec3> contact_points(const Shape& shape);

// Only for closed forms, because the contact points of a mesh contain this point.
std::optional<Vec3> support_point(const Shape& shape, Vec3 direction);

}  // namespace ensonify
