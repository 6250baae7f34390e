#include "world/ground.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ensonify {
namespace {

constexpr double kMaxCellsAcross = 2048;

// This margin lets points on an edge belong to both sides despite rounding.
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

std::optional<GroundPoint> solid_at(const PlaneShape&, const Pose& pose, double x, double y) {
  const Vec3 normal = upwards(rotate(pose.rotation, {0, 0, 1}));
  if (normal.z < 1e-9) return std::nullopt;
  const Vec3 from = pose.position_m;
  const double rise = normal.x * (x - from.x) + normal.y * (y - from.y);
  return GroundPoint{from.z - rise / normal.z, normal};
}

std::optional<GroundPoint> solid_at(const MeshShape&, const Pose&, double, double) { return {}; }

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
  return index(y_m, bounds_.low.y, bounds_.high.y, rows_) * columns_ +
         index(x_m, bounds_.low.x, bounds_.high.x, columns_);
}

void Ground::sort_triangles(const Mesh& mesh) {
  vertices_ = placed(mesh, pose_).vertices_m;
  for (const Vec3& p : vertices_) bounds_.add(p);
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
  const auto [low, high] = bounds_;
  if (!(x_m >= low.x && x_m <= high.x && y_m >= low.y && y_m <= high.y)) return std::nullopt;
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
  if (std::holds_alternative<MeshShape>(shape_)) return mesh_at(x_m, y_m);
  return std::visit([&](const auto& shape) { return solid_at(shape, pose_, x_m, y_m); }, shape_);
}

std::optional<GroundPoint> ground_at(const Shape& shape, const Pose& pose, double x_m, double y_m) {
  const auto* of_mesh = std::get_if<MeshShape>(&shape);
  if (of_mesh == nullptr) return Ground(shape, pose).at(x_m, y_m);
  std::vector<Vec3> vertices;
  vertices.reserve(of_mesh->mesh->vertices.size());
  for (const auto& v : of_mesh->mesh->vertices) {
    vertices.push_back(transform_point(pose, to_vec3(v)));
  }
  std::optional<GroundPoint> highest;
  for (const auto& corners : of_mesh->mesh->triangles) {
    const Vec3 &a = vertices[corners[0]], &b = vertices[corners[1]], &c = vertices[corners[2]];
    if (std::max({a.x, b.x, c.x}) < x_m || std::min({a.x, b.x, c.x}) > x_m) continue;
    const auto point = triangle_at(a, b, c, x_m, y_m);
    if (point && (!highest || point->height_m > highest->height_m)) highest = point;
  }
  return highest;
}

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

bool reaches(const std::array<Vec3, 3>& corner, Vec3 low, Vec3 high) {
  const auto apart = [](double a, double b, double c, double from, double to) {
    return std::max({a, b, c}) < from || std::min({a, b, c}) > to;
  };
  return !apart(corner[0].x, corner[1].x, corner[2].x, low.x, high.x) &&
         !apart(corner[0].y, corner[1].y, corner[2].y, low.y, high.y) &&
         !apart(corner[0].z, corner[1].z, corner[2].z, low.z, high.z);
}

// Triangles in the box, with the vertices they need.
PlacedTriangles cut_out(PlacedTriangles all, Vec3 low, Vec3 high) {
  PlacedTriangles kept;
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> number(all.vertices_m.size(), kNone);
  for (const auto& t : all.triangles) {
    if (!reaches({all.vertices_m[t[0]], all.vertices_m[t[1]], all.vertices_m[t[2]]}, low, high)) {
      continue;
    }
    auto& triangle = kept.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& own = number[t[k]];
      if (own == kNone) {
        own = static_cast<std::uint32_t>(kept.vertices_m.size());
        kept.vertices_m.push_back(all.vertices_m[t[k]]);
      }
      triangle[k] = own;
    }
  }
  return kept;
}

// Edges without a neighbor.
std::vector<Edge> rims_of(const PlacedTriangles& surface) {
  std::vector<Edge> edges, rims;
  for (const auto& t : surface.triangles) {
    for (int k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  for (const Edge& edge : edges) {
    if (!std::binary_search(edges.begin(), edges.end(), Edge{edge.second, edge.first})) {
      rims.push_back(edge);
    }
  }
  return rims;
}

}  // namespace

PlacedTriangles placed(const Mesh& mesh, const Pose& pose) {
  PlacedTriangles surface;
  surface.vertices_m.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) {
    surface.vertices_m.push_back(transform_point(pose, to_vec3(v)));
  }
  surface.triangles = mesh.triangles;
  return surface;
}

double area_m2(const PlacedTriangles& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    const Vec3 a = surface.vertices_m[t[0]];
    sum += length(cross(surface.vertices_m[t[1]] - a, surface.vertices_m[t[2]] - a)) / 2;
  }
  return sum;
}

PlacedTriangles ground_block(const Mesh& mesh, const Pose& pose, Vec3 low_m, Vec3 high_m) {
  PlacedTriangles block = cut_out(placed(mesh, pose), low_m, high_m);
  if (block.triangles.empty()) return block;
  const Vec3 up = rotate(pose.rotation, {0, 0, 1});
  double floor = dot(low_m, up);
  for (const double x : {low_m.x, high_m.x}) {
    for (const double y : {low_m.y, high_m.y}) {
      for (const double z : {low_m.z, high_m.z}) floor = std::min(floor, dot({x, y, z}, up));
    }
  }
  for (const Vec3& v : block.vertices_m) floor = std::min(floor, dot(v, up));
  floor -= 0.01 * length(high_m - low_m);  // no wall without height
  const std::vector<Edge> rims = rims_of(block);
  const auto count = static_cast<std::uint32_t>(block.vertices_m.size());
  for (std::uint32_t v = 0; v < count; ++v) {
    const Vec3 top = block.vertices_m[v];
    block.vertices_m.push_back(top - (dot(top, up) - floor) * up);
  }
  for (std::size_t t = block.triangles.size(); t-- > 0;) {
    const auto [a, b, c] = block.triangles[t];
    block.triangles.push_back({a + count, c + count, b + count});
  }
  for (const auto& [a, b] : rims) {
    block.triangles.push_back({b, a, a + count});
    block.triangles.push_back({b, a + count, b + count});
  }
  return block;
}

}  // namespace ensonify
