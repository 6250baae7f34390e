// Reads files with other libraries in this process. Only for `ensonify_import`, since a damaged
// file may crash it; the program calls load_mesh and the like.
//
//   import_mesh        as load_mesh (world/mesh.h)
//   import_density     as load_density_vdb
//   import_level_set   as load_level_set_vdb
//   check_mesh_file  check_mesh_text   whether a mesh file is complete, before it is read
//   drop_faces_without_area            repairs a mesh
//   broken_mesh  lower_case_extension
//
// std::bad_alloc passes through to main.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"
#include "world/density.h"
#include "world/mesh.h"

namespace ensonify {

Result<Mesh> import_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                         MeshReflectivity reflectivity);

Result<DensityGrid> import_density(const std::filesystem::path& file, const std::string& grid);

Result<Mesh> import_level_set(const std::filesystem::path& file, const std::string& grid,
                              Normals normals);

// Error with the file and the reason.
Error broken_mesh(const std::filesystem::path& file, const std::string& why);

// ".obj" of WRECK.OBJ.
std::string lower_case_extension(const std::filesystem::path& file);

// Errors (usage): a PLY or STL that ends too early (assimp would invent the missing faces), a .gltf
// with its buffers in a second file. A cut-off OBJ cannot be detected. Other errors are left to the
// reader.
Status check_mesh_file(const std::filesystem::path& file);

// The same for a file's bytes, in the format given by its name.
Status check_mesh_text(const std::filesystem::path& file, std::string_view bytes);

// Drops faces that are no thicker than the rounding of their coordinates (corners that coincide or
// lie on one line): rays practically never hit them, and their normals are noise. Adds a warning
// with their number.
void drop_faces_without_area(Mesh& mesh);

}  // namespace ensonify
