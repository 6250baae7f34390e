#include "world/ground_block.h"

#include <algorithm>
#include <utility>

namespace ensonify {
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

// Those in the box, with the vertices they need.
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

// Edges without a neighbour.
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
    surface.vertices_m.push_back(transform_point(pose, {v[0], v[1], v[2]}));
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
