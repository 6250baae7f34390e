// Meshes by assimp, which only this source and vertex_data.cpp include.
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <new>
#include <string>
#include <utility>

#include "core/counted.h"
#include "formats/files.h"
#include "world/import/import.h"
#include "world/import/polygon.h"
#include "world/import/vertex_data.h"

namespace ensonify {
namespace {

// Files as they are on disk, but for one.
class ChangedFile : public Assimp::DefaultIOSystem {
 public:
  // The bytes must outlive it.
  ChangedFile(std::string file, const std::string& bytes) : file_(std::move(file)), bytes_(bytes) {}

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (file != file_) return DefaultIOSystem::Open(file, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                      bytes_.size());
  }

 private:
  std::string file_;
  const std::string& bytes_;
};

// What may be the reason why a file cannot be read.
std::string required_text(const MeshBytes& bytes) {
  if (bytes.required.empty()) return {};
  return fmt::format(" (it requires {})", fmt::join(bytes.required, ", "));
}

bool is_gltf(const std::filesystem::path& file) {
  const std::string extension = lower_case_extension(file);
  return extension == ".gltf" || extension == ".glb";
}

bool says_which_way_is_up(const std::filesystem::path& file) {
  return is_gltf(file) || lower_case_extension(file) == ".dae";
}

Status check_faces(const aiScene& scene, const std::filesystem::path& file) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      if (part.mFaces[f].mNumIndices == 0) {
        return broken_mesh(file, fmt::format("face {} of part {} has no corners", f, m));
      }
      for (unsigned i = 0; i < part.mFaces[f].mNumIndices; ++i) {
        const unsigned vertex = part.mFaces[f].mIndices[i];
        if (vertex < part.mNumVertices) continue;
        return broken_mesh(file, fmt::format("face {} of part {} refers to vertex {} of {}", f, m,
                                             vertex, part.mNumVertices));
      }
    }
  }
  return {};
}

// The parts of a file that are to be read.
struct Wanted {
  bool smooth = false;
  bool brightness = false;  // of colors
  bool uv = false;
  bool colors = false;
  Coding coding = Coding::srgb;
  std::vector<std::uint8_t> part;  // of each of its meshes; empty: too many to distinguish
};

// The name of a mesh's material, or its own name if assimp invented the material.
std::string part_name(const aiScene& scene, const aiMesh& mesh) {
  if (mesh.mMaterialIndex < scene.mNumMaterials) {
    const std::string name = scene.mMaterials[mesh.mMaterialIndex]->GetName().C_Str();
    if (!name.empty() && name != AI_DEFAULT_MATERIAL_NAME) return name;
  }
  return mesh.mName.C_Str();
}

// Faces of a file that cross themselves: how many, and the first.
struct Crossings {
  std::size_t count = 0;
  std::string first;
};

// The corners of a face in its part.
std::vector<std::array<float, 3>> corners_of(const aiMesh& part, const aiFace& face) {
  std::vector<std::array<float, 3>> corners;
  for (unsigned i = 0; i < face.mNumIndices; ++i) {
    const aiVector3D& p = part.mVertices[face.mIndices[i]];
    corners.push_back({p.x, p.y, p.z});
  }
  return corners;
}

// Divides the faces of part `m` that have more than three corners.
void divide_part(aiMesh& part, unsigned m, Crossings& crossings) {
  std::size_t most = 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    most += std::max(part.mFaces[f].mNumIndices, 3u) - 2;
  }
  auto* faces = new aiFace[most];  // as assimp allocates them
  unsigned count = 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    aiFace& face = part.mFaces[f];
    if (face.mNumIndices <= 3) {
      std::swap(faces[count].mNumIndices, face.mNumIndices);
      std::swap(faces[count++].mIndices, face.mIndices);
      continue;
    }
    const auto corners = corners_of(part, face);
    const DividedFace divided = divide_face(corners);
    for (const auto& [a, b, c] : divided.triangles) {
      faces[count].mNumIndices = 3;
      faces[count++].mIndices =
          new unsigned[3]{face.mIndices[a], face.mIndices[b], face.mIndices[c]};
    }
    if (divided.simple || crossings.count++ > 0) continue;
    const auto& [x, y, z] = corners[0];
    crossings.first = fmt::format("face {} of part {} ('{}'), with a corner at ({:g}, {:g}, {:g})",
                                  f, m, part.mName.C_Str(), x, y, z);
  }
  delete[] part.mFaces;
  part.mFaces = faces;
  part.mNumFaces = count;
  part.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
  part.mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
}

// Before assimp's own steps, which need triangles. Its step that makes them covers notches and
// covers parts twice, depending on the first corner of a face.
void divide_faces(const aiScene& scene, Mesh& mesh) {
  Crossings crossings;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh& part = *scene.mMeshes[m];
    if ((part.mPrimitiveTypes & aiPrimitiveType_POLYGON) != 0) divide_part(part, m, crossings);
  }
  if (crossings.count == 0) return;
  const std::string more =
      crossings.count == 1 ? "" : fmt::format(" (and {} more)", crossings.count - 1);
  mesh.warnings.push_back(
      fmt::format("a face crosses itself or is far from flat, so that its area is in doubt: {}{}; "
                  "divide such faces into triangles before the export",
                  crossings.first, more));
}

// Before assimp's own steps, which take the materials away.
void name_parts(const aiScene& scene, Wanted& wanted, Mesh& mesh) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const std::string name = part_name(scene, *scene.mMeshes[m]);
    const auto found = std::find(mesh.part_names.begin(), mesh.part_names.end(), name);
    wanted.part.push_back(static_cast<std::uint8_t>(found - mesh.part_names.begin()));
    if (found == mesh.part_names.end()) mesh.part_names.push_back(name);
    if (mesh.part_names.size() <= 256) continue;
    wanted.part.clear();
    mesh.part_names.clear();
    mesh.warnings.push_back(
        "has more than 256 names of materials or parts; all parts count as one");
    return;
  }
}

// Whether a material of a mesh has an image of any kind.
bool has_texture(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const unsigned material = scene.mMeshes[m]->mMaterialIndex;
    if (material >= scene.mNumMaterials) continue;
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; ++type) {
      const auto use = static_cast<aiTextureType>(type);
      if (scene.mMaterials[material]->GetTextureCount(use) > 0) return true;
    }
  }
  return false;
}

// Before assimp's own steps, which take the materials away.
void warn_of_textures(const aiScene& scene, Mesh& mesh) {
  if (!has_texture(scene)) return;
  mesh.warnings.push_back(
      "its texture is ignored, as a mesh file cannot name images that scale reflectivity; for a "
      "pattern, use reflectivity: texture with an image in texture_file");
}

// Adds the meshes of a node and of all nodes below it, placed by the transforms on the path to
// them.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
              const Wanted& wanted, Mesh& mesh) {
  const aiMatrix4x4 placed = parent * node.mTransformation;
  const aiMatrix3x3 normal_matrix = aiMatrix3x3(placed).Inverse().Transpose();
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    if (!has_faces(part)) continue;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = placed * part.mVertices[v];
      mesh.vertices.push_back({p.x, p.y, p.z});
      if (wanted.brightness) {
        const aiColor4D& c = part.mColors[0][v];
        mesh.reflectivity.push_back((c.r + c.g + c.b) / 3);
      }
      if (wanted.colors) mesh.colors.push_back(linear_color(part, v, wanted.coding));
      if (wanted.uv) {
        const aiVector3D& uv = part.mTextureCoords[0][v];
        mesh.uv.push_back({uv.x, uv.y});
      }
      if (!wanted.smooth) continue;
      aiVector3D n;  // none: the tracer takes the face's
      if (part.HasNormals()) n = (normal_matrix * part.mNormals[v]).NormalizeSafe();
      mesh.normals.push_back({n.x, n.y, n.z});
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.push_back(
          {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
      if (!wanted.part.empty()) mesh.part.push_back(wanted.part[node.mMeshes[i]]);
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    add_node(scene, *node.mChildren[c], placed, wanted, mesh);
  }
}

// Intended lines and points cannot be distinguished from faces that were cut off.
void warn_of_lines(const aiScene& scene, Mesh& mesh) {
  std::size_t lines = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    for (unsigned f = 0; f < scene.mMeshes[m]->mNumFaces; ++f) {
      if (scene.mMeshes[m]->mFaces[f].mNumIndices < 3) ++lines;
    }
  }
  if (lines == 0) return;
  mesh.warnings.push_back(
      fmt::format("ignored {} with fewer than three corners: points and lines do not echo",
                  counted(lines, "face")));
}

// assimp invents the coordinates of faces that have none, if other faces of their part have some.
void warn_of_missing_uv(Mesh& mesh) {
  const auto is_origin = [&](std::uint32_t vertex) {
    return mesh.uv[vertex] == std::array<float, 2>{0, 0};
  };
  const auto missing = static_cast<std::size_t>(
      std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& triangle) {
        return std::all_of(triangle.begin(), triangle.end(), is_origin);
      }));
  if (missing == 0) return;
  mesh.warnings.push_back(
      fmt::format("{} of {} triangles have the texture coordinates (0, 0) at all corners, as faces "
                  "without any have; the lower left corner of the image scales them",
                  missing, mesh.triangles.size()));
}

// assimp rotates files with a given up axis so that y is up; here z is up.
aiMatrix4x4 placement_of(const std::filesystem::path& file, Vec3 scale) {
  aiMatrix4x4 upright;
  if (says_which_way_is_up(file)) {
    upright = aiMatrix4x4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  }
  aiMatrix4x4 scaling;
  aiMatrix4x4::Scaling(aiVector3D(static_cast<ai_real>(scale.x), static_cast<ai_real>(scale.y),
                                  static_cast<ai_real>(scale.z)),
                       scaling);
  return scaling * upright;
}

// What assimp is to do to a mesh once its file is read.
unsigned steps_for(const Wanted& wanted, Assimp::Importer& importer) {
  const bool keeps_colors = wanted.brightness || wanted.colors;
  unsigned steps = aiProcess_RemoveComponent;
  if (wanted.smooth) steps |= aiProcess_GenSmoothNormals;
  // assimp joins vertices of unequal colors or texture coordinates. Smooth normals do not need
  // joined ones.
  if (wanted.smooth && !keeps_colors && !wanted.uv) steps |= aiProcess_JoinIdenticalVertices;
  // Without the mesh's own materials, textures and colors, equal vertices can be joined.
  unsigned removed = aiComponent_MATERIALS;
  if (!keeps_colors) removed |= aiComponent_COLORS;
  if (!wanted.uv) removed |= aiComponent_TEXCOORDS;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, static_cast<int>(removed));
  return steps;
}

}  // namespace

Result<Mesh> import_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                         MeshReflectivity reflectivity, bool colors) {
  Wanted wanted;
  wanted.smooth = normals == Normals::smooth;
  wanted.brightness = reflectivity == MeshReflectivity::vertex_color;
  wanted.uv = reflectivity == MeshReflectivity::texture;
  Assimp::Importer importer;
  if ((colors || wanted.brightness) && lower_case_extension(file) == ".obj") {
    const Result<std::string> text = read_file(file);
    const Status sound = text ? check_obj_colors(file, *text) : Status();  // the reader says why
    if (!sound) return sound.error();
  }
  const Result<MeshBytes> bytes = prepare_mesh_file(file, wanted.uv);
  if (!bytes) return bytes.error();
  if (bytes->changed) importer.SetIOHandler(new ChangedFile(file.string(), *bytes->changed));
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    // assimp converts this exception to a text.
    if (importer.GetErrorString() == std::string("std::bad_alloc")) throw std::bad_alloc();
    return broken_mesh(file, fmt::format("cannot be read as a mesh: {}{}",
                                         importer.GetErrorString(), required_text(*bytes)));
  }
  // Before assimp's own steps, which trust the file.
  if (Status sound = check_faces(*scene, file); !sound) return sound.error();
  wanted.colors = colors && has_colors(*scene);
  wanted.coding = is_gltf(file) ? Coding::linear : Coding::srgb;
  Mesh mesh;
  mesh.warnings = bytes->warnings;
  name_parts(*scene, wanted, mesh);
  if (!wanted.uv) warn_of_textures(*scene, mesh);
  divide_faces(*scene, mesh);
  scene = importer.ApplyPostProcessing(steps_for(wanted, importer));
  if (scene == nullptr) return broken_mesh(file, "cannot be prepared by its reader");
  if (wanted.brightness || wanted.colors) {
    if (Status sound = check_colors(*scene, file, wanted.brightness); !sound) return sound.error();
  }
  if (wanted.uv) {
    if (Status sound = check_uv(*scene, file); !sound) return sound.error();
  }
  add_node(*scene, *scene->mRootNode, placement_of(file, scale), wanted, mesh);

  if (mesh.triangles.empty()) return broken_mesh(file, "holds no faces");
  if (Status possible = check_extent(mesh, file); !possible) return possible.error();
  drop_faces_without_area(mesh);
  if (mesh.triangles.empty()) return broken_mesh(file, "all its faces have zero area");
  warn_of_lines(*scene, mesh);
  if (wanted.uv) warn_of_missing_uv(mesh);
  for (std::string& warning : mesh.warnings) {
    warning = fmt::format("{}: {}", file.string(), warning);
  }
  return mesh;
}

}  // namespace ensonify
