#include "world/boxes.h"

#include <algorithm>
#include <limits>

namespace ensonify {
namespace {

// Grows around points.
class Bounds {
 public:
  void add(Vec3 p) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), std::min(low_.z, p.z)};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), std::max(high_.z, p.z)};
  }

  std::optional<OrientedBox> box() const {
    if (!(low_.x <= high_.x)) return std::nullopt;
    return OrientedBox{{0.5 * (low_ + high_), {}}, high_ - low_};
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low_{kInfinity, kInfinity, kInfinity};
  Vec3 high_{-kInfinity, -kInfinity, -kInfinity};
};

// The inverse of p -> (rows . p) + offset.
Vec3 mapped_back(const Affine& a, Vec3 p) {
  const Vec3 q = p - a.offset;
  const auto& [r0, r1, r2] = a.rows;
  const double determinant = dot(r0, cross(r1, r2));
  return (1 / determinant) * (q.x * cross(r1, r2) + q.y * cross(r2, r0) + q.z * cross(r0, r1));
}

std::optional<OrientedBox> grid_box(const DensityGrid& grid) {
  Bounds bounds;
  std::size_t cell = 0;
  for (int z = 0; z < grid.bricks[2]; ++z) {
    for (int y = 0; y < grid.bricks[1]; ++y) {
      for (int x = 0; x < grid.bricks[0]; ++x, ++cell) {
        if (grid.top[cell] < 0) continue;
        const int first[3] = {x, y, z};
        for (int corner = 0; corner < 8; ++corner) {
          const auto index = [&](int axis) {
            return static_cast<double>(grid.origin[axis] +
                                       DensityGrid::kCells * (first[axis] + (corner >> axis & 1)));
          };
          bounds.add(mapped_back(grid.index_from_local, {index(0), index(1), index(2)}));
        }
      }
    }
  }
  return bounds.box();
}

struct BoxOfShape {
  std::optional<OrientedBox> operator()(const PlaneShape&) const { return std::nullopt; }
  std::optional<OrientedBox> operator()(const MeshShape& shape) const {
    Bounds bounds;
    for (const auto& [x, y, z] : shape.mesh->vertices) bounds.add({x, y, z});
    return bounds.box();
  }
  template <class Closed>
  std::optional<OrientedBox> operator()(const Closed& shape) const {
    return OrientedBox{{}, 2.0 * half_extents(shape)};
  }
};

struct BoxOfDensity {
  std::optional<OrientedBox> operator()(const DensityEverywhere&) const { return std::nullopt; }
  std::optional<OrientedBox> operator()(const DensityBox& box) const {
    return OrientedBox{{}, 2.0 * box.half_extents_m};
  }
  std::optional<OrientedBox> operator()(const std::shared_ptr<const DensityGrid>& grid) const {
    return grid_box(*grid);
  }
};

}  // namespace

std::optional<OrientedBox> box_of(const Shape& shape) { return std::visit(BoxOfShape{}, shape); }

std::optional<OrientedBox> box_of(const Volume& volume) {
  std::optional<OrientedBox> box = std::visit(BoxOfDensity{}, volume.density);
  if (box) box->pose = compose(volume.pose, box->pose);
  return box;
}

std::optional<OrientedBox> box_of(const School& school) {
  Bounds bounds;
  for (const Vec3& fish : school.fish_m) bounds.add(fish);
  return bounds.box();
}

}  // namespace ensonify
