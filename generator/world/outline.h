// How much room a body takes, and where it may touch what it stands on.
//
//   Outline  outline_of     the upright cylinder around a turned body
//   contact_points          on its surface, in its own frame
//   support_point           the farthest one in a direction
#pragma once

#include <vector>

#include "core/vec.h"
#include "world/world.h"

namespace ensonify {

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
