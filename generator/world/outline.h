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

// Along the axes of the object's own frame; none for a plane. Of a mesh: around its vertices.
std::optional<OrientedBox> box_of(const Shape& shape);

// In the world. Of a school: around its fish, along the world's axes; none without fish. Of a
// density grid: around the bricks that hold anything, a cell of 8 samples wide at most too large on
// every side; none for a density without end or an empty grid.
std::optional<OrientedBox> box_of(const Volume& volume);
std::optional<OrientedBox> box_of(const School& school);

// Relative to the body's origin, or to any other point that it is moved by.
struct Outline {
  std::vector<std::array<double, 2>> hull_m;  // convex, counter-clockwise; one point of a circle
  double round_m = 0;                         // how far the body extends beyond the hull
  double x_m = 0, y_m = 0;                    // middle of the rectangle around it
  double radius_m = 0;                        // of the circle around that middle that holds it
  double low_m = 0, high_m = 0;
};

// Of a box or mesh the convex hull; of a sphere or upright cylinder the circle; of another cylinder
// 0.5 % too wide at most. A plane has none; it is not asked for one.
Outline outline_of(const Shape& shape, const Quat& rotation);
Outline turned(const Outline& outline, double yaw_rad);
Outline moved(Outline outline, Vec3 by_m);

// From one outline to the nearest point of another: of length `distance_m`, below zero where they
// overlap (then the depth along the direction in which it is least).
struct Gap {
  double distance_m = 0;
  double x = 0, y = 0;  // unit length
};
Gap gap_between(const Outline& from, const Outline& to);

// All vertices of a mesh, and sufficiently dense points on other shapes: 150 of a box, 225 of a
// cylinder, 200 of a sphere.
std::vector<Vec3> contact_points(const Shape& shape);

// For closed forms; a mesh has it among its contact points.
std::optional<Vec3> support_point(const Shape& shape, Vec3 direction);

}  // namespace ensonify
