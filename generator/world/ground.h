// The surface of an object as it is seen from straight above, in double precision.
//
//   Ground   at: height and normal under a point
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/vec.h"
#include "world/world.h"

namespace ensonify {

struct GroundPoint {
  double height_m = 0;  // of the highest surface
  Vec3 normal;          // unit length, upwards
};

// Closed forms by their own intersection, rooms from within (their floor); meshes triangle by
// triangle, found through a grid over x and y. `shape` must outlive it.
class Ground {
 public:
  // `shape` must outlive it.
  Ground(const Shape& shape, const Pose& pose);
  Ground(const Shape&& shape, const Pose& pose) = delete;

  // Nothing beside the object and where its surface is upright.
  std::optional<GroundPoint> at(double x_m, double y_m) const;

 private:
  void sort_triangles(const Mesh& mesh);
  std::size_t cell(double x_m, double y_m) const;
  std::optional<GroundPoint> mesh_at(double x_m, double y_m) const;

  const Shape& shape_;
  Pose pose_;
  std::vector<Vec3> vertices_;  // of a mesh, in the world
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  double west_m_ = 0, south_m_ = 0, east_m_ = 0, north_m_ = 0;
  std::size_t columns_ = 1, rows_ = 1;
  std::vector<std::uint32_t> first_;  // of each cell's triangles in `listed_`, one more at the end
  std::vector<std::uint32_t> listed_;
};

}  // namespace ensonify
