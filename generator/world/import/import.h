// Reads files with other libraries in this process. Only for `ensonify_import`, since a damaged
// file may crash it; the program calls load_mesh and the like.
//
//   import_mesh        as load_mesh (world/mesh.h)
//   import_density     as load_density_vdb
//   import_level_set   as load_level_set_vdb
//
// std::bad_alloc passes through to main.cpp.
#pragma once

#include <filesystem>
#include <string>

#include "core/error.h"
#include "world/density.h"
#include "world/mesh.h"

namespace ensonify {

Result<Mesh> import_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                         MeshReflectivity reflectivity);

Result<DensityGrid> import_density(const std::filesystem::path& file, const std::string& grid);

Result<Mesh> import_level_set(const std::filesystem::path& file, const std::string& grid,
                              Normals normals);

}  // namespace ensonify
