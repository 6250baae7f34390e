#include "world/outline.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

std::optional<OrientedBox> box_of(const Bounds& bounds) {
  if (bounds.empty()) return std::nullopt;
  return OrientedBox{{bounds.middle(), {}}, bounds.size()};
}

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
  return box_of(bounds);
}

struct BoxOfShape {
  std::optional<OrientedBox> operator()(const PlaneShape&) const { return std::nullopt; }
  std::optional<OrientedBox> operator()(const MeshShape& shape) const {
    Bounds bounds;
    for (const auto& v : shape.mesh->vertices) bounds.add(to_vec3(v));
    return box_of(bounds);
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
  return box_of(bounds);
}

namespace {

constexpr int kOnFace = 5;  // points along each side of a box's face
constexpr int kOnRim = 32;  // around a cylinder
constexpr int kOnSphere = 200;

std::vector<Vec3> corners_of(const BoxShape& box) {
  const Vec3 half = box.half_size_m;
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(
        {i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
  }
  return corners;
}

// The circle is around the middle of the bounding rectangle.
Outline around(const std::vector<Vec3>& points, const Quat& rotation) {
  Bounds bounds;
  for (const Vec3& point : points) bounds.add(rotate(rotation, point));
  const Vec3 middle = bounds.middle();
  Outline outline{middle.x, middle.y, 0, bounds.low.z, bounds.high.z};
  for (const Vec3& point : points) {
    const Vec3 p = rotate(rotation, point);
    outline.radius_m = std::max(outline.radius_m, std::hypot(p.x - outline.x_m, p.y - outline.y_m));
  }
  return outline;
}

// Half the cylinder's extent along a direction that makes an angle of this cosine with its axis.
double half_extent(const CylinderShape& cylinder, double cosine) {
  return cylinder.half_height_m * cosine +
         cylinder.radius_m * std::sqrt(std::max(0.0, 1 - cosine * cosine));
}

// Level directions make angles with the axis of cosines up to its level part; the extent is largest
// towards the rim's corner, at cosine h / hypot(h, r).
Outline around(const CylinderShape& cylinder, const Quat& rotation) {
  const Vec3 axis = rotate(rotation, {0, 0, 1});
  const double level = std::min(1.0, std::hypot(axis.x, axis.y));
  const double corner =
      cylinder.half_height_m / std::hypot(cylinder.half_height_m, cylinder.radius_m);
  const double height = half_extent(cylinder, std::min(1.0, std::abs(axis.z)));
  return {0, 0, half_extent(cylinder, std::min(level, corner)), -height, height};
}

std::vector<Vec3> points_on(const BoxShape& box) {
  const Vec3 half = box.half_size_m;
  std::vector<Vec3> points;
  for (int i = 0; i < kOnFace; ++i) {
    for (int j = 0; j < kOnFace; ++j) {
      const double u = -1 + 2.0 * i / (kOnFace - 1), v = -1 + 2.0 * j / (kOnFace - 1);
      for (const double side : {-1.0, 1.0}) {
        points.push_back({side * half.x, u * half.y, v * half.z});
        points.push_back({u * half.x, side * half.y, v * half.z});
        points.push_back({u * half.x, v * half.y, side * half.z});
      }
    }
  }
  return points;
}

std::vector<Vec3> points_on(const CylinderShape& cylinder) {
  std::vector<Vec3> points;
  const auto ring = [&](double radius, double z) {
    for (int i = 0; i < kOnRim; ++i) {
      const double angle = 2 * kPi * i / kOnRim;
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  };
  for (int level = -2; level <= 2; ++level) {
    ring(cylinder.radius_m, cylinder.half_height_m * level / 2);
  }
  for (const double side : {-1.0, 1.0}) {
    ring(cylinder.radius_m / 2, side * cylinder.half_height_m);
    points.push_back({0, 0, side * cylinder.half_height_m});
  }
  return points;
}

// On a spiral of equal areas.
std::vector<Vec3> points_on(const SphereShape& sphere) {
  std::vector<Vec3> points;
  for (int i = 0; i < kOnSphere; ++i) {
    const double z = 1 - (2.0 * i + 1) / kOnSphere;
    const double angle = kPi * (3 - std::sqrt(5.0)) * i;
    const double level = std::sqrt(1 - z * z);
    points.push_back(sphere.radius_m * Vec3{level * std::cos(angle), level * std::sin(angle), z});
  }
  return points;
}

std::vector<Vec3> points_on(const PlaneShape&) { return {}; }

std::vector<Vec3> points_on(const MeshShape& shape) {
  std::vector<Vec3> points;
  for (const auto& v : shape.mesh->vertices) points.push_back(to_vec3(v));
  return points;
}

}  // namespace

Outline outline_of(const Shape& shape, const Quat& rotation) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return around(corners_of(*box), rotation);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    return around(*cylinder, rotation);
  }
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    return {0, 0, sphere->radius_m, -sphere->radius_m, sphere->radius_m};
  }
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) return around(points_on(*mesh), rotation);
  return {};
}

std::vector<Vec3> contact_points(const Shape& shape) {
  return std::visit([](const auto& s) { return points_on(s); }, shape);
}

std::optional<Vec3> support_point(const Shape& shape, Vec3 direction) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    return sphere->radius_m * normalized(direction);
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    const double level = std::hypot(direction.x, direction.y);
    const double scale = level > 0 ? cylinder->radius_m / level : 0;
    return Vec3{scale * direction.x, scale * direction.y,
                std::copysign(cylinder->half_height_m, direction.z)};
  }
  return std::nullopt;
}

}  // namespace ensonify
