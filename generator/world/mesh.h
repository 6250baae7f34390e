// Triangle meshes, and the functions that read them.
//
//   Mesh  to_vec3  to_floats  Bounds
//   load_mesh             from OBJ, STL, PLY, glTF and DAE
//   load_level_set_vdb    the surface of an OpenVDB level set
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

// Vertices in meters, z up, in the object's frame. They are floats, as in the tracer.
struct Mesh {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<float, 3>> normals;  // one per vertex if smooth ones are requested
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> reflectivity;  // one per vertex if requested: factor on the material's
  std::vector<std::array<float, 3>> colors;  // one per vertex if requested: linear red, green and
                                             // blue, 0 ... 1; NaN: that of the material
  std::vector<std::array<float, 2>> uv;      // one per vertex if requested, v up
  std::vector<std::uint8_t> part;            // one per triangle: index into part_names
  std::vector<std::string> part_names;       // in a file: of the material, otherwise of the part
  std::vector<std::string> warnings;         // repairs, each with the file's name
};

inline Vec3 to_vec3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }
inline std::array<float, 3> to_floats(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// The box around the points that were added, along the axes.
struct Bounds {
  Vec3 low{kEmpty, kEmpty, kEmpty}, high = -low;

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool empty() const { return !(low.x <= high.x); }
  Vec3 middle() const { return 0.5 * (low + high); }
  Vec3 size() const { return high - low; }

  static constexpr double kEmpty = std::numeric_limits<double>::infinity();
};

enum class Normals { face, smooth };

// material: only the object's material. vertex_color: its reflectivity times the color of the mesh
// (mean of red, green and blue, 0 ... 1), interpolated over each face. A face that shares no
// corners and has corners of equal color has this color. texture: its reflectivity times an image
// (world/reflectivity_image.h) at the texture coordinates of the mesh.
enum class MeshReflectivity { material, vertex_color, texture };

// Reads OBJ, STL, PLY, glTF and DAE. DAE and glTF define their up axis and unit, and are converted
// to z up and meters. The other formats define neither and are read unchanged. All parts of the
// file become one mesh; `scale` multiplies the coordinates along x, y and z of the resulting mesh.
// Normals stay normal to the surface. With `colors`, vertices keep the colors of the file, if any:
// linear ones of glTF (COLOR_0), otherwise sRGB. If a file has more than 256 names, `part` stays
// empty, with a warning. Faces without area, points and lines are ignored, with a warning; a face
// that crosses itself is warned of. Errors (usage): a file that cannot be read as a mesh, is cut
// off or has no faces with area; a face that refers to a missing vertex; a vertex that is not
// finite; a mesh of more than 1000 km, or so far from its origin that rounding distorts it; a .gltf
// with its buffers in a second file, or that requires an extension that is not supported; requested
// vertex colors or texture coordinates that are missing; read colors outside 0 ... 1, or on only
// some vertices of an OBJ.
Result<Mesh> load_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                       MeshReflectivity reflectivity = MeshReflectivity::material,
                       bool colors = false);

// The zero surface of one grid of floats as triangles, two for each voxel that it passes through.
// They are counter-clockwise as seen from the side of positive distance, and in meters by the
// grid's own transform. Smooth normals are the means of the faces around a vertex, weighted by
// area. `grid` may be empty if the file has only one. Errors (usage, naming the file): a file that
// is damaged or not a .vdb; a grid that is missing, not a level set of floats, has no linear
// transform, has a background not above zero (inside out), holds a distance that is not finite, has
// no surface, or one of more than 1000 km or distorted by rounding.
Result<Mesh> load_level_set_vdb(const std::filesystem::path& file, const std::string& grid,
                                Normals normals);

}  // namespace ensonify
