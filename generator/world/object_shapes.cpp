#include "world/object_shapes.h"

#include <fmt/format.h>

#include "world/everyday_objects/everyday_objects.h"

namespace ensonify {
namespace {

Normals normals_of(bool smooth) { return smooth ? Normals::smooth : Normals::face; }

// The mesh with that key, loaded by load() if missing. `warnings`: those of a new mesh.
template <class Load>
Result<Shape> mesh_shape(const MeshKey& key, MeshCache& cache, std::vector<std::string>& warnings,
                         Load load) {
  std::shared_ptr<const Mesh>& cached = cache.meshes[key];
  if (!cached) {
    Result<std::shared_ptr<const Mesh>> mesh = load();
    if (!mesh) return mesh.error();
    cached = std::move(*mesh);
    warnings = cached->warnings;
  }
  return Shape(MeshShape{cached});
}

Result<std::shared_ptr<const Mesh>> shared(Result<Mesh> mesh) {
  if (!mesh) return mesh.error();
  return std::make_shared<const Mesh>(std::move(*mesh));
}

std::string text_of(const MeshKey& key) {
  const auto& [file, scale, smooth, reflectivity, colors] = key;
  return fmt::format("{}\n{:a} {:a} {:a} {} {} {}", file, scale[0], scale[1], scale[2], smooth,
                     static_cast<int>(reflectivity), colors);
}

template <class Load>
Result<Shape> file_shape(const MeshKey& key, MeshCache& cache, std::vector<std::string>& warnings,
                         Load load) {
  return mesh_shape(key, cache, warnings, [&]() -> Result<std::shared_ptr<const Mesh>> {
    return cache.library->mesh(text_of(key), load);
  });
}

MeshReflectivity reflectivity_of(const MeshSpec& spec) {
  if (!spec.texture_file.empty()) return MeshReflectivity::texture;
  return spec.vertex_reflectivity ? MeshReflectivity::vertex_color : MeshReflectivity::material;
}

MeshKey key_of(const MeshSpec& spec, bool colors) {
  return {spec.file.string(), spec.scale, spec.smooth_normals, reflectivity_of(spec), colors};
}

// It is unique, because no mesh file ends in .vdb and no name of a grid contains a line feed.
MeshKey key_of(const LevelSetSpec& spec) {
  return {spec.file.string() + "\n" + spec.grid,
          {},
          spec.smooth_normals,
          MeshReflectivity::material,
          false};
}

Result<Shape> shape_of(const MeshSpec& spec, MeshCache& meshes,
                       std::vector<std::string>& warnings) {
  return file_shape(key_of(spec, meshes.colors), meshes, warnings, [&] {
    const auto& [x, y, z] = spec.scale;
    return load_mesh(spec.file, {x, y, z}, normals_of(spec.smooth_normals), reflectivity_of(spec),
                     meshes.colors);
  });
}

}  // namespace

Result<Shape> shape_of(const ShapeSpec& spec, MeshCache& meshes,
                       std::vector<std::string>& warnings) {
  if (const auto* box = std::get_if<BoxSpec>(&spec)) {
    return Shape(
        BoxShape{{box->size_m[0] / 2, box->size_m[1] / 2, box->size_m[2] / 2}, box->inside});
  }
  if (const auto* sphere = std::get_if<SphereSpec>(&spec)) {
    return Shape(SphereShape{sphere->radius_m, sphere->inside});
  }
  if (const auto* cylinder = std::get_if<CylinderSpec>(&spec)) {
    return Shape(CylinderShape{cylinder->radius_m, cylinder->height_m / 2});
  }
  if (const auto* mesh = std::get_if<MeshSpec>(&spec)) return shape_of(*mesh, meshes, warnings);
  if (const auto* solid = std::get_if<LevelSetSpec>(&spec)) {
    return file_shape(key_of(*solid), meshes, warnings, [&] {
      return load_level_set_vdb(solid->file, solid->grid, normals_of(solid->smooth_normals));
    });
  }
  if (const auto* model = std::get_if<ModelSpec>(&spec)) {
    // No file has this name, since mesh files have an extension.
    const MeshKey key{std::string(word_of(model->kind)),
                      {model->size_m},
                      false,
                      MeshReflectivity::material,
                      false};
    return mesh_shape(key, meshes, warnings,
                      [&] { return shared(model_mesh(model->kind, model->size_m)); });
  }
  return Shape(PlaneShape{});
}

std::string library_key(const ShapeSpec& spec, bool colors) {
  if (const auto* mesh = std::get_if<MeshSpec>(&spec)) return text_of(key_of(*mesh, colors));
  const auto* solid = std::get_if<LevelSetSpec>(&spec);
  return solid == nullptr ? "" : text_of(key_of(*solid));
}

}  // namespace ensonify
