// Convex polygons and bodies.
//
//   convex_hull   of points in a plane
//   Triangle  solid_angle_sr   as seen from a point
//   RestFace  rest_faces   faces on which a body can stand
#pragma once

#include <array>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

using Point2 = std::array<double, 2>;

// The hull is counter-clockwise and has no points on its edges (Andrew 1979). If the points lie on
// one line, or are fewer than three, the hull consists of their ends.
std::vector<Point2> convex_hull(std::vector<Point2> points);

// Counter-clockwise as seen from outside.
using Triangle = std::array<Vec3, 3>;

// Positive from inside, negative from outside (van Oosterom and Strackee 1983).
double solid_angle_sr(const Triangle& triangle, Vec3 from);

// A face of the convex hull that lies below the hull's center of mass, so that a body rests stably
// on it.
struct RestFace {
  Vec3 normal;       // outwards, unit length
  double share = 0;  // of the solid angles of all rest faces, from the center of mass
};

// Faces of the hull of the points, sorted by share, the largest first. Qhull computes the hull
// (Barber et al. 1996). Error (usage): the points lie in one plane.
Result<std::vector<RestFace>> rest_faces(const std::vector<Vec3>& points);

}  // namespace ensonify
