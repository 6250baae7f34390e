// Reads files with other libraries in this process. Only for `ensonify_import`, since a damaged
// file may crash it; the program calls load_mesh and the like.
//
//   import_mesh        as load_mesh (world/mesh.h)
//   import_density     as load_density_vdb
//   import_level_set   as load_level_set_vdb
//   MeshBytes  prepare_mesh_file  prepare_mesh_bytes   whether a mesh file is complete, and its
//                      bytes as the reader understands them
//   check_extent             whether a mesh is of a possible size and place
//   drop_faces_without_area  repairs a mesh
//   broken_mesh  lower_case_extension
//
// std::bad_alloc passes through to main.cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "world/density.h"
#include "world/mesh.h"

namespace ensonify {

Result<Mesh> import_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                         MeshReflectivity reflectivity, bool colors = false);

Result<DensityGrid> import_density(const std::filesystem::path& file, const std::string& grid);

Result<Mesh> import_level_set(const std::filesystem::path& file, const std::string& grid,
                              Normals normals);

// Error with the file and the reason.
Error broken_mesh(const std::filesystem::path& file, const std::string& why);

// ".obj" of WRECK.OBJ.
std::string lower_case_extension(const std::filesystem::path& file);

struct MeshBytes {
  std::optional<std::string> changed;  // none if the reader understands the file as it is
  std::vector<std::string> required;   // extensions of glTF
  std::vector<std::string> warnings;
};

// What assimp would read wrongly, as it reads it: glTF with whole numbers (gltf.h); an STL with
// bytes behind its last face, with capitals or after blank lines; text after a byte order mark.
// `uv`: whether texture coordinates are wanted. Errors (usage): a PLY or STL that ends too early
// (assimp would invent the missing faces), an STL whose facets are no triangles, a .gltf with its
// buffers in a second file, an extension of glTF that is not supported, UTF-16. A cut-off OBJ
// cannot be detected. Other errors are left to the reader.
Result<MeshBytes> prepare_mesh_file(const std::filesystem::path& file, bool uv);

// The same for a file's bytes, in the format given by its name.
Result<MeshBytes> prepare_mesh_bytes(const std::filesystem::path& file, std::string bytes, bool uv);

// Errors (usage): a vertex that is not finite; a mesh of more than 1000 km; one so far from its
// origin that single precision rounds its coordinates by more than a centimeter, where another
// origin would help.
Status check_extent(const Mesh& mesh, const std::filesystem::path& file);

// Drops faces that are no thicker than the rounding of their coordinates (corners that coincide or
// lie on one line): rays practically never hit them, and their normals are noise. Adds a warning
// with their number.
void drop_faces_without_area(Mesh& mesh);

}  // namespace ensonify
