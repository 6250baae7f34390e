// The share of an object that lies where the sonar hears nothing.
//
//   surface_samples   points on a surface
//   truncated_share   the share of them that is outside of the fan
#pragma once

#include <span>
#include <vector>

#include "core/sonar.h"
#include "core/vec.h"
#include "world/world.h"

namespace ensonify {

inline constexpr int kSurfaceSamples = 1000;

// kSurfaceSamples points in the shape's frame, spread evenly over its area, the same in every call;
// none for a plane, which is infinite.
std::vector<Vec3> surface_samples(const Shape& shape);

// The share of the points that lie outside of all beam cells, outside of the fan in elevation, or
// outside of the ranges [range_min, range_max], along straight lines from the sonar. Hidden points
// count as well. NaN if there are no points.
double truncated_share(std::span<const Vec3> points_m, const Pose& object_in_world,
                       const Pose& sonar_in_world, const Sonar& sonar);

}  // namespace ensonify
