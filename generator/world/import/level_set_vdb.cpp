#include "world/import/import.h"

#include <openvdb/tools/VolumeToMesh.h>

#include <cmath>
#include <limits>
#include <optional>

#include "world/import/mesh_repair.h"
#include "world/import/vdb_file.h"

namespace ensonify {
namespace {

GridTrouble level_set_trouble(const openvdb::GridBase& base, const openvdb::FloatGrid* grid) {
  if (grid == nullptr) {
    return fmt::format("holds {}, accepted is a grid of float", base.valueType());
  }
  const openvdb::GridClass kind = base.getGridClass();
  if (kind == openvdb::GRID_FOG_VOLUME) {
    return "is a fog volume, accepted is a level set; densities belong under volumes, vdb";
  }
  if (kind != openvdb::GRID_LEVEL_SET && kind != openvdb::GRID_UNKNOWN) {
    return fmt::format("is a {}, accepted is a level set, whose values are distances",
                       openvdb::GridBase::gridClassToString(kind));
  }
  if (!base.transform().isLinear()) return "is no regular grid, accepted is a linear transform";
  if (!(grid->background() > 0)) {
    return fmt::format("has the background {}, accepted is a distance above 0: negative inside",
                       grid->background());
  }
  if (grid->activeVoxelCount() == 0) {
    return "has no active voxel, accepted is a grid that holds one";
  }
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    if (std::isfinite(*value)) continue;
    return "holds a distance that is not finite, accepted are finite numbers";
  }
  if (!is_near_origin(grid->evalActiveVoxelBoundingBox())) {
    return fmt::format("has voxels beyond index {}, accepted is a grid nearer to its origin",
                       kFarthestVdbIndex);
  }
  return std::nullopt;
}

// Whether the transform turns right hands into left ones.
bool is_mirrored(const openvdb::math::Transform& transform) {
  const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
  const auto axis = [&](double x, double y, double z) {
    return transform.indexToWorld(openvdb::Vec3d(x, y, z)) - origin;
  };
  return axis(1, 0, 0).dot(axis(0, 1, 0).cross(axis(0, 0, 1))) < 0;
}

void add_smooth_normals(Mesh& mesh) {
  std::vector<Vec3> sums(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const auto& v = mesh.vertices[triangle[k]];
      corner[k] = {v[0], v[1], v[2]};
    }
    const Vec3 area = cross(corner[1] - corner[0], corner[2] - corner[0]);
    for (const std::uint32_t v : triangle) sums[v] = sums[v] + area;
  }
  for (const Vec3& sum : sums) {
    const Vec3 n = length(sum) > 0 ? normalized(sum) : Vec3{};
    mesh.normals.push_back(
        {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
  }
}

Mesh mesh_of(const openvdb::FloatGrid& grid) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads);
  Mesh mesh;
  mesh.vertices.reserve(points.size());
  for (const openvdb::Vec3s& p : points) mesh.vertices.push_back({p.x(), p.y(), p.z()});
  // OpenVDB's faces are seen clockwise from outside.
  const bool turned = !is_mirrored(grid.transform());
  mesh.triangles.reserve(2 * quads.size());
  for (openvdb::Vec4I q : quads) {
    if (turned) std::swap(q[1], q[3]);
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

Result<Mesh> load(const std::filesystem::path& file, const std::string& name, Normals normals) {
  Result<openvdb::GridBase::Ptr> base = read_vdb_grid(file, name);
  if (!base) return base.error();
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(*base);
  if (const GridTrouble trouble = level_set_trouble(**base, grid.get())) {
    return grid_trouble(**base, *trouble);
  }
  Mesh mesh = mesh_of(*grid);
  for (const auto& vertex : mesh.vertices) {
    for (const float x : vertex) {
      if (!std::isfinite(x)) return grid_trouble(**base, "has a surface beyond all numbers");
    }
  }
  // Voxels that the surface only touches leave slivers; they open no gap.
  drop_faces_without_area(mesh);
  mesh.warnings.clear();
  if (mesh.triangles.empty()) {
    return grid_trouble(**base, "has no surface, accepted is a grid with distances of both signs");
  }
  if (normals == Normals::smooth) add_smooth_normals(mesh);
  return mesh;
}

}  // namespace

Result<Mesh> import_level_set(const std::filesystem::path& file, const std::string& grid,
                              Normals normals) {
  return load_from_vdb(file, [&] { return load(file, grid, normals); });
}

}  // namespace ensonify
