// Coarse meshes of round bodies.
//
//   ball_mesh    an icosahedron, divided twice: 320 faces, corners on the sphere
//   prism_mesh   a cylinder of segments, open or closed
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/units.h"
#include "core/vec.h"
#include "world/mesh.h"

namespace ensonify::test {

inline std::uint32_t add_vertex(Mesh& mesh, Vec3 place) {
  mesh.vertices.push_back(to_floats(place));
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

inline Mesh ball_mesh(double radius_m) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  const std::array<Vec3, 12> corners = {{{-1, g, 0},
                                         {1, g, 0},
                                         {-1, -g, 0},
                                         {1, -g, 0},
                                         {0, -1, g},
                                         {0, 1, g},
                                         {0, -1, -g},
                                         {0, 1, -g},
                                         {g, 0, -1},
                                         {g, 0, 1},
                                         {-g, 0, -1},
                                         {-g, 0, 1}}};
  std::vector<std::array<Vec3, 3>> faces;
  for (const auto& [a, b, c] : std::initializer_list<std::array<int, 3>>{
           {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}) {
    faces.push_back({corners[a], corners[b], corners[c]});
  }
  for (int round = 0; round < 2; ++round) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3 ab = normalized(normalized(a) + normalized(b));
      const Vec3 bc = normalized(normalized(b) + normalized(c));
      const Vec3 ca = normalized(normalized(c) + normalized(a));
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = finer;
  }
  Mesh mesh;
  for (const auto& face : faces) {
    std::array<std::uint32_t, 3> triangle{};
    for (int i = 0; i < 3; ++i) triangle[i] = add_vertex(mesh, radius_m * normalized(face[i]));
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

// About z. Every third side has its other diagonal, so that the means of the faces around a vertex
// are no normals of the cylinder.
inline Mesh prism_mesh(double radius_m, double height_m, int segments, bool closed) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(segments);
  for (const double end : {-0.5, 0.5}) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 2 * kPi * i / segments;
      add_vertex(mesh, {radius_m * std::cos(angle), radius_m * std::sin(angle), end * height_m});
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t k = (i + 1) % n;
    if (i % 3 == 0) {
      mesh.triangles.insert(mesh.triangles.end(), {{i, k, n + i}, {k, n + k, n + i}});
    } else {
      mesh.triangles.insert(mesh.triangles.end(), {{i, k, n + k}, {i, n + k, n + i}});
    }
  }
  for (std::uint32_t i = 1; closed && i + 1 < n; ++i) {
    mesh.triangles.insert(mesh.triangles.end(), {{0, i + 1, i}, {n, n + i, n + i + 1}});
  }
  return mesh;
}

}  // namespace ensonify::test
