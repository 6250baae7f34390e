// Convex polygons and bodies.
//
//   convex_hull   of points in a plane
//   Triangle  solid_angle_sr   as seen from a point
//   RestFace  rest_faces   on which a body can stand
#pragma once

#include <array>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

using Point2 = std::array<double, 2>;

// Counter-clockwise, without points on its edges (Andrew 1979). Points on one line, or fewer than
// three, give their ends.
std::vector<Point2> convex_hull(std::vector<Point2> points);

// Counter-clockwise as seen from outside.
using Triangle = std::array<Vec3, 3>;

// Above zero from inside, below zero from outside (van Oosterom and Strackee 1983).
double solid_angle_sr(const Triangle& triangle, Vec3 from);

// A face of the convex hull below the hull's center of mass: a body rests stably on it.
struct RestFace {
  Vec3 normal;       // outwards, unit length
  double share = 0;  // solid angle of the face from the center of mass, of that of all rest faces
};

// Faces of the hull of the points, sorted by share, the largest first; the hull is by Qhull (Barber
// et al. 1996). Error (usage): the points lie in one plane.
Result<std::vector<RestFace>> rest_faces(const std::vector<Vec3>& points);

}  // namespace ensonify
