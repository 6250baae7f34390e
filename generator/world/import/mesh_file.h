// What is looked at in a mesh file before it is read, and what is put right in the mesh.
//
//   check_mesh_file  check_mesh_text   whether a file is all there
//   drop_faces_without_area
//   broken_mesh  lower_case_extension
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"
#include "world/mesh.h"

namespace ensonify {

// The file, then why it cannot be used.
Error broken_mesh(const std::filesystem::path& file, const std::string& why);

// ".obj" of WRECK.OBJ.
std::string lower_case_extension(const std::filesystem::path& file);

// Errors (usage): a PLY or STL that ends before what it announces (assimp would make faces of what
// is not there), a .gltf with its buffers in a second file. Nothing tells a cut OBJ from a whole
// one. What cannot be opened or understood is left to the reading.
Status check_mesh_file(const std::filesystem::path& file);

// The same of a file's bytes, in the format that its name tells.
Status check_mesh_text(const std::filesystem::path& file, std::string_view bytes);

// Leaves out faces that are no thicker than the rounding of their coordinates (corners that
// coincide or lie in a line): they stop no ray to speak of, and their normals are noise. Adds a
// warning that counts them.
void drop_faces_without_area(Mesh& mesh);

}  // namespace ensonify
