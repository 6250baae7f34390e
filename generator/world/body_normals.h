// The smooth body that a mesh stands for, by its normals. Private to world/.
//
//   turned_alike                a mesh whose faces turn the same way around
//   BodyNormals  body_normals   at the corners of each triangle
//   corner_place  unit_or_zero
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vec.h"
#include "world/mesh.h"

namespace ensonify {

// Faces that meet at a larger angle form an edge of the body.
inline constexpr double kLargestBend_deg = 40;

// Neighbors that differ more in their width across the common side form an edge as well.
inline constexpr double kLargestStep = 4;

// The mesh with the corners of some triangles in the other order, so that triangles with a common
// side turn the same way around, as far as the surface has two sides. Without such a triangle, the
// mesh as it is.
Mesh turned_alike(const Mesh& mesh);

struct BodyNormals {
  // By triangle and corner, unit vectors.
  std::vector<std::array<Vec3, 3>> corner;
  // By triangle and the side that is opposite to the corner: the triangle behind it, or none at a
  // border and where more than two meet.
  std::vector<std::array<std::uint32_t, 3>> neighbor;
  static constexpr std::uint32_t kNone = 0xffffffff;
};

// The normals of the body that the mesh stands for. They are the mesh's own where these say more
// than the means of the faces and depart from the face by less than kLargestBend_deg. Otherwise
// they come from the faces around a vertex that no edge of the body separates, with Max's weights
// (N. Max, Journal of Graphics Tools 4(2), 1999), which are exact where the vertices lie on a
// sphere and for a right-angled prism around a circular cylinder.
// `mesh`: turned_alike.
BodyNormals body_normals(const Mesh& mesh);

inline Vec3 corner_place(const Mesh& mesh, std::size_t triangle, int corner) {
  return to_vec3(mesh.vertices[mesh.triangles[triangle][corner]]);
}

inline Vec3 unit_or_zero(Vec3 v) {
  const double size = length(v);
  return size > 0 ? (1 / size) * v : Vec3{};
}

}  // namespace ensonify
