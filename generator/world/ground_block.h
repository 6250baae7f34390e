// Terrain as a closed solid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vec.h"
#include "world/mesh.h"

namespace ensonify {

// Triangles in the world, in double precision.
struct PlacedTriangles {
  std::vector<Vec3> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

PlacedTriangles placed(const Mesh& mesh, const Pose& pose);
double area_m2(const PlacedTriangles& surface);

// The triangles that reach into the box, walls below their rims, and a floor below all of the box;
// "below" is along -z of the pose. Empty where no triangle reaches the box.
PlacedTriangles ground_block(const Mesh& mesh, const Pose& pose, Vec3 low_m, Vec3 high_m);

}  // namespace ensonify
