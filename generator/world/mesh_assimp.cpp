// The only source that includes assimp.
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <cmath>

#include "world/mesh.h"

namespace ensonify {
namespace {

Error broken(const std::filesystem::path& file, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}: {}", file.string(), why)};
}

bool says_which_way_is_up(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".dae" || extension == ".gltf" || extension == ".glb";
}

// Adds the meshes of a node and of all below it, placed by the transforms on the way.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, bool smooth,
              Mesh& mesh) {
  const aiMatrix4x4 placed = parent * node.mTransformation;
  const aiMatrix3x3 normal_matrix = aiMatrix3x3(placed).Inverse().Transpose();
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = placed * part.mVertices[v];
      mesh.vertices.push_back({p.x, p.y, p.z});
      if (!smooth) continue;
      const aiVector3D n = (normal_matrix * part.mNormals[v]).NormalizeSafe();
      mesh.normals.push_back({n.x, n.y, n.z});
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines reflect nothing
      mesh.triangles.push_back(
          {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    add_node(scene, *node.mChildren[c], placed, smooth, mesh);
  }
}

}  // namespace

Result<Mesh> load_mesh(const std::filesystem::path& file, double scale, Normals normals) {
  const bool smooth = normals == Normals::smooth;
  Assimp::Importer importer;
  unsigned steps = aiProcess_Triangulate;
  if (smooth) steps |= aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices;
  // Without the mesh's own materials, textures and colours, equal vertices can be joined.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_COLORS | aiComponent_TEXCOORDS | aiComponent_MATERIALS);
  const aiScene* scene = importer.ReadFile(file.string(), steps | aiProcess_RemoveComponent);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    return broken(file, fmt::format("not a mesh that can be read: {}", importer.GetErrorString()));
  }
  // assimp turns every file that says which way is up so that y is up; here z is.
  aiMatrix4x4 placement;
  if (says_which_way_is_up(file)) {
    placement = aiMatrix4x4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  }
  aiMatrix4x4 scaling;
  aiMatrix4x4::Scaling(aiVector3D(static_cast<ai_real>(scale)), scaling);
  Mesh mesh;
  add_node(*scene, *scene->mRootNode, scaling * placement, smooth, mesh);

  if (mesh.triangles.empty()) return broken(file, "holds no faces");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (const float coordinate : mesh.vertices[v]) {
      if (!std::isfinite(coordinate)) {
        return broken(file, fmt::format("vertex {} is not a finite number", v));
      }
    }
  }
  return mesh;
}

}  // namespace ensonify
