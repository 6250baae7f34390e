#include "world/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.h"
#include "world/convex.h"

namespace ensonify {
namespace {

std::optional<OrientedBox> box_of(const Bounds& bounds) {
  if (bounds.empty()) return std::nullopt;
  return OrientedBox{{bounds.middle(), {}}, bounds.size()};
}

// Applies the inverse of p -> (rows . p) + offset.
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

// Sets the middle and circle of a hull's outline; heights are unchanged.
void close_outline(Outline& outline) {
  Bounds bounds;
  for (const auto& [x, y] : outline.hull_m) bounds.add({x, y, 0});
  outline.x_m = bounds.middle().x;
  outline.y_m = bounds.middle().y;
  outline.radius_m = 0;
  for (const auto& [x, y] : outline.hull_m) {
    outline.radius_m =
        std::max(outline.radius_m, std::hypot(x - outline.x_m, y - outline.y_m));
  }
  outline.radius_m += outline.round_m;
}

Outline around(const std::vector<Vec3>& points, const Quat& rotation) {
  Outline outline;
  Bounds bounds;
  std::vector<std::array<double, 2>> seen;
  seen.reserve(points.size());
  for (const Vec3& point : points) {
    const Vec3 p = rotate(rotation, point);
    bounds.add(p);
    seen.push_back({p.x, p.y});
  }
  outline.low_m = bounds.low.z;
  outline.high_m = bounds.high.z;
  outline.hull_m = convex_hull(std::move(seen));
  close_outline(outline);
  return outline;
}

// Half the cylinder's extent along a direction that makes an angle of this cosine with its axis.
double half_extent(const CylinderShape& cylinder, double cosine) {
  return cylinder.half_height_m * cosine +
         cylinder.radius_m * std::sqrt(std::max(0.0, 1 - cosine * cosine));
}

Outline around(const CylinderShape& cylinder, const Quat& rotation) {
  const Vec3 axis = rotate(rotation, {0, 0, 1});
  const double height = half_extent(cylinder, std::min(1.0, std::abs(axis.z)));
  if (axis.x == 0 && axis.y == 0) {
    return {{{0, 0}}, cylinder.radius_m, 0, 0, cylinder.radius_m, -height, height};
  }
  // Corners of a polygon around each disc.
  const double radius = cylinder.radius_m / std::cos(kPi / kOnRim);
  std::vector<Vec3> points;
  for (int i = 0; i < kOnRim; ++i) {
    const double angle = 2 * kPi * i / kOnRim;
    for (const double side : {-1.0, 1.0}) {
      points.push_back({radius * std::cos(angle), radius * std::sin(angle),
                        side * cylinder.half_height_m});
    }
  }
  Outline outline = around(points, rotation);
  outline.low_m = -height;
  outline.high_m = height;
  return outline;
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

// The points lie on a spiral of equal areas.
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
    const double radius = sphere->radius_m;
    return {{{0, 0}}, radius, 0, 0, radius, -radius, radius};
  }
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) return around(points_on(*mesh), rotation);
  return {};
}

Outline turned(const Outline& outline, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  Outline result = outline;
  for (auto& [x, y] : result.hull_m) {
    const double old = x;
    x = c * old - s * y;
    y = s * old + c * y;
  }
  close_outline(result);
  return result;
}

Outline moved(Outline outline, Vec3 by_m) {
  for (auto& [x, y] : outline.hull_m) x += by_m.x, y += by_m.y;
  outline.x_m += by_m.x, outline.y_m += by_m.y;
  outline.low_m += by_m.z, outline.high_m += by_m.z;
  return outline;
}

namespace {

double dot2(Point2 a, Point2 b) { return a[0] * b[0] + a[1] * b[1]; }
Point2 minus(Point2 a, Point2 b) { return {a[0] - b[0], a[1] - b[1]}; }

struct Separation {
  double distance = -std::numeric_limits<double>::infinity();
  Point2 direction{1, 0};
};

// The distance by which `there` lies beyond the edges of `here`, along the outward normal for which
// it is largest.
Separation beyond_edges(const std::vector<Point2>& here, const std::vector<Point2>& there) {
  Separation most;
  for (std::size_t i = 0; here.size() > 1 && i < here.size(); ++i) {
    const Point2 edge = minus(here[(i + 1) % here.size()], here[i]);
    const double along = std::hypot(edge[0], edge[1]);
    const Point2 normal{edge[1] / along, -edge[0] / along};
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point2& point : there) {
      nearest = std::min(nearest, dot2(minus(point, here[i]), normal));
    }
    if (nearest > most.distance) most = {nearest, normal};
  }
  return most;
}

// The shortest vector from a point to an edge of `hull`.
Point2 way_to(const std::vector<Point2>& hull, Point2 from) {
  Point2 best = minus(hull[0], from);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point2 a = hull[i], edge = minus(hull[(i + 1) % hull.size()], a);
    const double squared = dot2(edge, edge);
    const double part =
        squared > 0 ? std::clamp(dot2(minus(from, a), edge) / squared, 0.0, 1.0) : 0;
    const Point2 way = minus({a[0] + part * edge[0], a[1] + part * edge[1]}, from);
    if (dot2(way, way) < dot2(best, best)) best = way;
  }
  return best;
}

// Valid only for hulls that do not overlap.
Point2 shortest_way(const std::vector<Point2>& from, const std::vector<Point2>& to) {
  Point2 best = way_to(to, from[0]);
  for (const Point2& point : from) {
    const Point2 way = way_to(to, point);
    if (dot2(way, way) < dot2(best, best)) best = way;
  }
  for (const Point2& point : to) {
    const Point2 back = way_to(from, point);
    if (dot2(back, back) < dot2(best, best)) best = {-back[0], -back[1]};
  }
  return best;
}

}  // namespace

Gap gap_between(const Outline& from, const Outline& to) {
  const double round = from.round_m + to.round_m;
  Separation out = beyond_edges(from.hull_m, to.hull_m);
  const Separation back = beyond_edges(to.hull_m, from.hull_m);
  if (back.distance > out.distance) {
    out = {back.distance, {-back.direction[0], -back.direction[1]}};
  }
  const bool are_points = from.hull_m.size() == 1 && to.hull_m.size() == 1;
  if (!are_points && out.distance <= 0) {
    return {out.distance - round, out.direction[0], out.direction[1]};
  }
  const Point2 way = shortest_way(from.hull_m, to.hull_m);
  const double distance = std::hypot(way[0], way[1]);
  if (distance == 0) return {-round, 1, 0};
  return {distance - round, way[0] / distance, way[1] / distance};
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
