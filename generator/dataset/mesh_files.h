// Checks of the meshes of a sequence's scene, world.ply and world.glb (world/scene_mesh.h writes
// them). Private to dataset/.
//
//   mesh_ply_fault  glb_fault   what is wrong, or an empty text
#pragma once

#include <filesystem>
#include <string>

namespace ensonify {

// Checks header and length.
std::string mesh_ply_fault(const std::filesystem::path& path);

// Checks the heads of file and chunks, and the length.
std::string glb_fault(const std::filesystem::path& path);

}  // namespace ensonify
