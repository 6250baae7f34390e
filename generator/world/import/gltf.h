// What has to be done to a glTF file before assimp, which takes whole numbers for floats.
//
//   prepare_gltf
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

// The file with its positions, normals, tangents and texture coordinates as floats where they are
// whole numbers (KHR_mesh_quantization, and texture coordinates of glTF itself). With `uv`, texture
// coordinates are those of the image of the material's base color (KHR_texture_transform). None if
// nothing is to be changed. `required`: the extensions without which the file cannot be read.
// Errors (usage): one of them is not supported; a damaged accessor. A file that is not JSON is left
// to the reader.
Result<std::optional<std::string>> prepare_gltf(const std::filesystem::path& file,
                                                std::string_view bytes, bool uv,
                                                std::vector<std::string>& required);

}  // namespace ensonify
