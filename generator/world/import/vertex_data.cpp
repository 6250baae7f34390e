#include "world/import/vertex_data.h"

#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "world/import/import.h"

namespace ensonify {
namespace {

// Numbers of a line "v x y z ..." of an OBJ file; 0 in other lines.
std::size_t numbers_of_vertex(std::string_view line) {
  if (!line.starts_with("v ")) return 0;
  std::size_t numbers = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto blank = [&](std::size_t at) { return line[at] <= ' '; };
    if (blank(i - 1) && !blank(i)) ++numbers;
  }
  return numbers;
}

// The error of `check(m, part)` at the first part with faces that has one.
template <class Check>
Status check_parts(const aiScene& scene, const Check& check) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    if (!has_faces(*scene.mMeshes[m])) continue;
    if (Status sound = check(m, *scene.mMeshes[m]); !sound) return sound;
  }
  return {};
}

double decoded(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

}  // namespace

bool has_faces(const aiMesh& part) {
  return (part.mPrimitiveTypes & (aiPrimitiveType_TRIANGLE | aiPrimitiveType_POLYGON)) != 0;
}

Status check_uv(const aiScene& scene, const std::filesystem::path& file) {
  return check_parts(scene, [&](unsigned m, const aiMesh& part) -> Status {
    if (!part.HasTextureCoords(0)) {
      return broken_mesh(file,
                         fmt::format("part {} ('{}') has no texture coordinates, which "
                                     "reflectivity: texture needs; add them (UV unwrapping), or "
                                     "use reflectivity: material",
                                     m, part.mName.C_Str()));
    }
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& uv = part.mTextureCoords[0][v];
      if (std::isfinite(uv.x) && std::isfinite(uv.y)) continue;
      return broken_mesh(file, fmt::format("the texture coordinates of vertex {} of part {} are "
                                           "not finite numbers",
                                           v, m));
    }
    return {};
  });
}

bool has_colors(const aiScene& scene) {
  return std::any_of(scene.mMeshes, scene.mMeshes + scene.mNumMeshes, [](const aiMesh* part) {
    return has_faces(*part) && part->HasVertexColors(0);
  });
}

Status check_colors(const aiScene& scene, const std::filesystem::path& file, bool all) {
  return check_parts(scene, [&](unsigned m, const aiMesh& part) -> Status {
    if (!part.HasVertexColors(0)) {
      if (!all) return {};
      return broken_mesh(file,
                         fmt::format("part {} ('{}') has no vertex colors, which reflectivity: "
                                     "vertex_color needs; add them, or use reflectivity: "
                                     "material",
                                     m, part.mName.C_Str()));
    }
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiColor4D& c = part.mColors[0][v];
      for (const float channel : {c.r, c.g, c.b}) {
        if (channel >= 0 && channel <= 1) continue;
        return broken_mesh(file,
                           fmt::format("vertex {} of part {} has the color {} {} {}; expected red, "
                                       "green and blue from 0 to 1",
                                       v, m, c.r, c.g, c.b));
      }
    }
    return {};
  });
}

Status check_obj_colors(const std::filesystem::path& file, std::string_view text) {
  // The last lines with and without a color.
  std::size_t with = 0, without = 0;
  for (std::size_t at = 0, line = 1; at < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view whole = text.substr(at, end - at);
    const std::string_view row = whole.substr(0, whole.find('#'));
    const std::size_t count = numbers_of_vertex(row);
    // assimp passes over such a number.
    if (count > 0 && row.find(" .") != std::string_view::npos) {
      return broken_mesh(file,
                         fmt::format("line {}: a number begins with a point; expected a digit "
                                     "before it, such as 0.5",
                                     line));
    }
    if (count > 0) (count == 6 ? with : without) = line;
    if (with > 0 && without > 0) {
      return broken_mesh(file, fmt::format("line {}: the vertex has no color, but that of line {} "
                                           "has one; give all vertices a color (x y z r g b), or "
                                           "none",
                                           without, with));
    }
    at = end + 1;
  }
  return {};
}

std::array<float, 3> linear_color(const aiMesh& part, unsigned vertex, Coding coding) {
  if (!part.HasVertexColors(0)) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    return {kNone, kNone, kNone};
  }
  const aiColor4D& c = part.mColors[0][vertex];
  if (coding == Coding::linear) return {c.r, c.g, c.b};
  std::array<float, 3> linear{c.r, c.g, c.b};
  for (float& channel : linear) channel = static_cast<float>(decoded(double{channel}));
  return linear;
}

}  // namespace ensonify
