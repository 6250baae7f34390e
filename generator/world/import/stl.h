// STL files as assimp understands them.
//
//   is_binary_stl  prepare_stl
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"
#include "world/import/import.h"

namespace ensonify {

// Whether as many faces follow as the number in its head says. No text has a number so small there.
bool is_binary_stl(std::string_view bytes);

// Sets `prepared.changed` if assimp would not read the bytes, and warns of bytes that are ignored.
// Errors (usage): text that is cut off; a facet without three corners.
Status prepare_stl(const std::filesystem::path& file, std::string bytes, MeshBytes& prepared);

}  // namespace ensonify
