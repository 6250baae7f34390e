// The shapes of a scenario's objects.
//
//   MeshCache  shape_of   closed forms, and meshes that are read once
//   library_key           of a mesh that is read from a file
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/error.h"
#include "scenario/scenario.h"
#include "world/mesh.h"
#include "world/world.h"

namespace ensonify {

// File, scale, whether normals are smooth, reflectivity, whether colors are read.
using MeshKey = std::tuple<std::string, std::array<double, 3>, bool, MeshReflectivity, bool>;

// The meshes of one world and the images on them. The warnings of a mesh are reported once.
struct MeshCache {
  MeshLibrary* library = nullptr;  // of files, for this world and others
  bool colors = false;             // for a camera
  std::map<MeshKey, std::shared_ptr<const Mesh>> meshes = {};
};

// Of all shapes but terrain. `warnings`: those of a mesh that is new to the cache. Errors: those of
// load_mesh, load_level_set_vdb and model_mesh.
Result<Shape> shape_of(const ShapeSpec& spec, MeshCache& meshes,
                       std::vector<std::string>& warnings);

// The key of the mesh in the library; empty for shapes that are not read from a file.
std::string library_key(const ShapeSpec& spec, bool colors);

}  // namespace ensonify
