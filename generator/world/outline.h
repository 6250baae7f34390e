// How much room a body takes, and where it may touch what it stands on.
//
//   box_of                  the box around what stands in the world: the labels' 3-D boxes
//   Outline  outline_of     the upright cylinder around a turned body
//   contact_points          on its surface, in its own frame
//   support_point           the farthest one in a direction
#pragma once

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

// Relative to the body's origin.
struct Outline {
  double x_m = 0, y_m = 0;  // of the circle's centre
  double radius_m = 0;
  double low_m = 0, high_m = 0;
};

// A plane has none; it is not asked for one.
Outline outline_of(const Shape& shape, const Quat& rotation);

// All vertices of a mesh, and enough of the other shapes that what lies between them is small:
// 150 of a box, 225 of a cylinder, 200 of a sphere.
std::vector<Vec3> contact_points(const Shape& shape);

// Of a closed form; that of a mesh is among its contact points.
std::optional<Vec3> support_point(const Shape& shape, Vec3 direction);

}  // namespace ensonify
