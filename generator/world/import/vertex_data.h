// What the vertices of a mesh have besides places and normals.
//
//   has_faces  check_uv
//   has_colors  check_colors  check_obj_colors
//   Coding  linear_color
#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "core/error.h"

struct aiMesh;
struct aiScene;

namespace ensonify {

// Not points and lines alone.
bool has_faces(const aiMesh& part);

// Errors (usage): a part with faces has no texture coordinates, or some that are not finite.
Status check_uv(const aiScene& scene, const std::filesystem::path& file);

// Whether any part with faces has colors.
bool has_colors(const aiScene& scene);

// Errors (usage): a channel outside 0 ... 1; with `all`, a part with faces that has no colors.
Status check_colors(const aiScene& scene, const std::filesystem::path& file, bool all);

// Errors (usage): only some vertices of an OBJ file have colors, which assimp would give to others,
// or a number of a vertex begins with a point, which assimp does not count.
Status check_obj_colors(const std::filesystem::path& file, std::string_view text);

// Of colors in a file: the transfer function of IEC 61966-2-1, or none.
enum class Coding { srgb, linear };

// Of a vertex, as shares of light; NaN in a part without colors.
std::array<float, 3> linear_color(const aiMesh& part, unsigned vertex, Coding coding);

}  // namespace ensonify
