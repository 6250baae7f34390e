#include "world/import/mesh_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ensonify {
namespace {

bool has_area(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  std::array<Vec3, 3> corner;
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& v = mesh.vertices[triangle[i]];
    corner[i] = {v[0], v[1], v[2]};
    for (const float x : v) largest = std::max(largest, std::abs(static_cast<double>(x)));
  }
  const Vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0], bc = corner[2] - corner[1];
  const double longest = std::max({length(ab), length(ac), length(bc)});
  const double rounding = std::numeric_limits<float>::epsilon() * largest;
  return length(cross(ab, ac)) > rounding * longest;
}

}  // namespace

void drop_faces_without_area(Mesh& mesh) {
  const std::size_t before = mesh.triangles.size();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < before; ++t) {
    if (!has_area(mesh, mesh.triangles[t])) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    if (!mesh.part.empty()) mesh.part[kept] = mesh.part[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  if (!mesh.part.empty()) mesh.part.resize(kept);
  const std::size_t dropped = before - mesh.triangles.size();
  if (dropped == 0) return;
  mesh.warnings.push_back(
      fmt::format("{} of {} faces left out: they have no area (corners that coincide or lie in a "
                  "line)",
                  dropped, before));
}

}  // namespace ensonify
