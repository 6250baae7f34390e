// The surface of an object seen from straight above, and terrain as a closed solid.
//
//   Ground   at                   height and normal under a point, in double precision
//   ground_at                     the same for a single point
//   PlacedTriangles  placed       a mesh in the world
//   ground_block                  terrain with walls and a floor
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/vec.h"
#include "world/mesh.h"
#include "world/world.h"

namespace ensonify {

struct GroundPoint {
  double height_m = 0;  // of the highest surface
  Vec3 normal;          // unit length, upwards
};

// Closed forms use their own intersection; rooms are met from inside, at their floor. Meshes are
// tested triangle by triangle, with a grid over x and y as an index.
class Ground {
 public:
  // `shape` must outlive it.
  Ground(const Shape& shape, const Pose& pose);
  Ground(const Shape&& shape, const Pose& pose) = delete;

  // Returns none outside the object and where its surface is vertical.
  std::optional<GroundPoint> at(double x_m, double y_m) const;

 private:
  void sort_triangles(const Mesh& mesh);
  std::size_t cell(double x_m, double y_m) const;
  std::optional<GroundPoint> mesh_at(double x_m, double y_m) const;

  const Shape& shape_;
  Pose pose_;
  std::vector<Vec3> vertices_;  // of a mesh, in the world
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  Bounds bounds_;  // of the vertices
  std::size_t columns_ = 1, rows_ = 1;
  std::vector<std::uint32_t> first_;  // index of each cell's triangles in `listed_`, with the end
  std::vector<std::uint32_t> listed_;
};

// Ground::at, faster for a single point, since it makes no index.
std::optional<GroundPoint> ground_at(const Shape& shape, const Pose& pose, double x_m, double y_m);

// Triangles in the world, in double precision.
struct PlacedTriangles {
  std::vector<Vec3> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

PlacedTriangles placed(const Mesh& mesh, const Pose& pose);
double area_m2(const PlacedTriangles& surface);

// Consists of the triangles that reach into the box, walls below their edges, and a floor below the
// whole box; "below" is along -z of the pose. Empty if no triangle reaches the box.
PlacedTriangles ground_block(const Mesh& mesh, const Pose& pose, Vec3 low_m, Vec3 high_m);

}  // namespace ensonify
