// Triangle meshes from files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

// Vertices in metres, z up, in the object's frame. In float, as the tracer keeps them.
struct Mesh {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<float, 3>> normals;  // one a vertex where smooth ones are asked for
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> reflectivity;    // one a vertex where asked for: factor on the material's
  std::vector<std::string> warnings;  // what was put right in the file, each behind its name
};

enum class Normals { face, smooth };

// material: the object's material alone. vertex_color: its reflectivity times the colour of the
// mesh (mean of red, green and blue, 0 ... 1), interpolated over each face; a face whose corners
// are its own and of one colour has that.
enum class MeshReflectivity { material, vertex_color };

// Reads OBJ, STL, PLY, glTF and DAE. DAE and glTF say which way is up and how long a unit is: they
// come out z up and in metres. The others say neither: they are taken as they are. All parts of
// the file become one mesh; `scale` multiplies every coordinate.
// Faces without area, points and lines are left out, with a warning.
// Errors (usage): a file that cannot be read as a mesh, that is cut off, that has no faces with an
// area, a face that names a vertex it does not have, a vertex that is not a finite number, a .gltf
// with its buffers in a second file, vertex colours asked for where there are none.
Result<Mesh> load_mesh(const std::filesystem::path& file, double scale, Normals normals,
                       MeshReflectivity reflectivity = MeshReflectivity::material);

}  // namespace ensonify
