#include "world/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ensonify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxCellsAcross = 2048;

// Points on an edge belong to both sides, whatever rounding says.
constexpr double kOnEdge = -1e-12;

Vec3 upwards(Vec3 normal) { return normal.z < 0 ? -normal : normal; }

double reach(const BoxShape& box) { return length(box.half_size_m); }
double reach(const SphereShape& sphere) { return sphere.radius_m; }
double reach(const CylinderShape& c) { return std::hypot(c.radius_m, c.half_height_m); }

template <class Solid>
std::optional<GroundPoint> solid_at(const Solid& solid, const Pose& pose, double x, double y) {
  const double top = pose.position_m.z + reach(solid) + 1;
  const Ray down{inverse_transform_point(pose, {x, y, top}),
                 rotate(conjugate(pose.rotation), {0, 0, -1})};
  const auto hit = intersect(solid, down, 0);
  if (!hit) return std::nullopt;
  return GroundPoint{top - hit->range_m, upwards(rotate(pose.rotation, hit->normal))};
}

std::optional<GroundPoint> plane_at(const Pose& pose, double x, double y) {
  const Vec3 normal = upwards(rotate(pose.rotation, {0, 0, 1}));
  if (normal.z < 1e-9) return std::nullopt;
  const Vec3 from = pose.position_m;
  const double rise = normal.x * (x - from.x) + normal.y * (y - from.y);
  return GroundPoint{from.z - rise / normal.z, normal};
}

std::optional<GroundPoint> triangle_at(Vec3 a, Vec3 b, Vec3 c, double x, double y) {
  const double ux = b.x - a.x, uy = b.y - a.y, vx = c.x - a.x, vy = c.y - a.y;
  const double area = ux * vy - uy * vx;
  if (area == 0) return std::nullopt;
  const double s = ((x - a.x) * vy - (y - a.y) * vx) / area;
  const double t = (ux * (y - a.y) - uy * (x - a.x)) / area;
  if (!(s >= kOnEdge && t >= kOnEdge && s + t <= 1 - kOnEdge)) return std::nullopt;
  return GroundPoint{a.z + s * (b.z - a.z) + t * (c.z - a.z),
                     upwards(normalized(cross(b - a, c - a)))};
}

}  // namespace

Ground::Ground(const Shape& shape, const Pose& pose) : shape_(shape), pose_(pose) {
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) sort_triangles(*mesh->mesh);
}

std::size_t Ground::cell(double x_m, double y_m) const {
  const auto index = [](double at, double from, double to, std::size_t count) {
    const double u = to > from ? (at - from) / (to - from) : 0;
    const double i =
        std::clamp(std::floor(u * static_cast<double>(count)), 0.0, static_cast<double>(count - 1));
    return static_cast<std::size_t>(i);
  };
  return index(y_m, south_m_, north_m_, rows_) * columns_ + index(x_m, west_m_, east_m_, columns_);
}

void Ground::sort_triangles(const Mesh& mesh) {
  west_m_ = south_m_ = kInfinity;
  east_m_ = north_m_ = -kInfinity;
  for (const auto& v : mesh.vertices) {
    const Vec3 p = transform_point(pose_, {v[0], v[1], v[2]});
    vertices_.push_back(p);
    west_m_ = std::min(west_m_, p.x), east_m_ = std::max(east_m_, p.x);
    south_m_ = std::min(south_m_, p.y), north_m_ = std::max(north_m_, p.y);
  }
  triangles_ = mesh.triangles;
  const double across = std::ceil(std::sqrt(static_cast<double>(triangles_.size())));
  columns_ = rows_ = static_cast<std::size_t>(std::clamp(across, 1.0, kMaxCellsAcross));
  const auto for_each_cell = [&](const std::array<std::uint32_t, 3>& corners, auto&& visit) {
    const Vec3 a = vertices_[corners[0]], b = vertices_[corners[1]], c = vertices_[corners[2]];
    const std::size_t low = cell(std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}));
    const std::size_t high = cell(std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}));
    for (std::size_t row = low / columns_; row <= high / columns_; ++row) {
      for (std::size_t i = low % columns_; i <= high % columns_; ++i) visit(row * columns_ + i);
    }
  };
  first_.assign(columns_ * rows_ + 1, 0);
  for (const auto& corners : triangles_) {
    for_each_cell(corners, [&](std::size_t at) { ++first_[at + 1]; });
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  listed_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for_each_cell(triangles_[t], [&](std::size_t at) { listed_[next[at]++] = t; });
  }
}

std::optional<GroundPoint> Ground::mesh_at(double x_m, double y_m) const {
  if (!(x_m >= west_m_ && x_m <= east_m_ && y_m >= south_m_ && y_m <= north_m_)) {
    return std::nullopt;
  }
  std::optional<GroundPoint> highest;
  const std::size_t at = cell(x_m, y_m);
  for (std::uint32_t i = first_[at]; i < first_[at + 1]; ++i) {
    const auto& corners = triangles_[listed_[i]];
    const auto point =
        triangle_at(vertices_[corners[0]], vertices_[corners[1]], vertices_[corners[2]], x_m, y_m);
    if (point && (!highest || point->height_m > highest->height_m)) highest = point;
  }
  return highest;
}

std::optional<GroundPoint> Ground::at(double x_m, double y_m) const {
  return std::visit(
      [&](const auto& shape) -> std::optional<GroundPoint> {
        using S = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<S, MeshShape>) {
          return mesh_at(x_m, y_m);
        } else if constexpr (std::is_same_v<S, PlaneShape>) {
          return plane_at(pose_, x_m, y_m);
        } else {
          return solid_at(shape, pose_, x_m, y_m);
        }
      },
      shape_);
}

}  // namespace ensonify
