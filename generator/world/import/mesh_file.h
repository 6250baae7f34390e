// Whether a mesh file is all there, before it is read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"

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

}  // namespace ensonify
