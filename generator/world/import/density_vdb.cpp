#include "world/import/import.h"

#include <cmath>
#include <optional>

#include "world/import/vdb_file.h"

namespace ensonify {
namespace {

constexpr float kMaxDensity = 1e6f;

GridTrouble density_trouble(const openvdb::GridBase& base, const openvdb::FloatGrid* grid) {
  if (grid == nullptr) {
    return fmt::format("holds {}, accepted is a grid of float", base.valueType());
  }
  const openvdb::GridClass kind = base.getGridClass();
  if (kind != openvdb::GRID_FOG_VOLUME && kind != openvdb::GRID_UNKNOWN) {
    return fmt::format("is a {}, accepted is a fog volume, whose values are densities",
                       openvdb::GridBase::gridClassToString(kind));
  }
  if (!base.transform().isLinear()) return "is no regular grid, accepted is a linear transform";
  if (grid->background() != 0) {
    return fmt::format("has the background {}, accepted is 0: the density ends somewhere",
                       grid->background());
  }
  if (grid->activeVoxelCount() == 0)
    return "has no active voxel, accepted is a grid that holds one";
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    if (*value >= 0 && *value <= kMaxDensity) continue;
    return fmt::format("holds the density {}, accepted are 0 to {}", *value, kMaxDensity);
  }
  if (!is_near_origin(grid->evalActiveVoxelBoundingBox())) {
    return fmt::format("has voxels beyond index {}, accepted is a grid nearer to its origin",
                       kFarthestVdbIndex);
  }
  return std::nullopt;
}

Affine index_from_world(const openvdb::math::Transform& transform) {
  const openvdb::Vec3d origin = transform.worldToIndex({0, 0, 0});
  const openvdb::Vec3d x = transform.worldToIndex({1, 0, 0}) - origin;
  const openvdb::Vec3d y = transform.worldToIndex({0, 1, 0}) - origin;
  const openvdb::Vec3d z = transform.worldToIndex({0, 0, 1}) - origin;
  Affine affine;
  for (int i = 0; i < 3; ++i) affine.rows[i] = {x[i], y[i], z[i]};
  affine.offset = {origin[0], origin[1], origin[2]};
  return affine;
}

bool is_finite(const Affine& affine) {
  return std::isfinite(length(affine.rows[0]) + length(affine.rows[1]) + length(affine.rows[2]) +
                       length(affine.offset));
}

Result<DensityGrid> density_of(const openvdb::FloatGrid& grid) {
  const Affine affine = index_from_world(grid.transform());
  const openvdb::Vec3d size = grid.voxelSize();
  const double spacing_m = std::min({size[0], size[1], size[2]});
  if (!(spacing_m > 0) || !is_finite(affine)) {
    return Error{ErrorKind::usage, "has voxels without size, accepted is a size above 0"};
  }
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  openvdb::FloatGrid::ConstAccessor voxels = grid.getConstAccessor();
  DensitySource source;
  source.low = {box.min()[0], box.min()[1], box.min()[2]};
  source.high = {box.max()[0], box.max()[1], box.max()[2]};
  // A brick's samples lie in up to eight leaves, which have its size.
  source.is_empty = [&](std::array<int, 3> first) {
    for (int i = 0; i < 8; ++i) {
      const openvdb::Coord at(first[0] + 8 * (i & 1), first[1] + 8 * (i >> 1 & 1),
                              first[2] + 8 * (i >> 2));
      if (voxels.probeConstLeaf(at) != nullptr || voxels.isValueOn(at)) return false;
    }
    return true;
  };
  source.fill = [&](std::array<int, 3> first, float* samples) {
    for (int z = 0; z < DensityGrid::kCorners; ++z) {
      for (int y = 0; y < DensityGrid::kCorners; ++y) {
        for (int x = 0; x < DensityGrid::kCorners; ++x) {
          float value = 0;
          const bool on = voxels.probeValue({first[0] + x, first[1] + y, first[2] + z}, value);
          *samples++ = on ? value : 0;
        }
      }
    }
  };
  return make_density_grid(source, affine, spacing_m);
}

Result<DensityGrid> load(const std::filesystem::path& path, const std::string& name) {
  Result<openvdb::GridBase::Ptr> base = read_vdb_grid(path, name);
  if (!base) return base.error();
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(*base);
  if (const GridTrouble trouble = density_trouble(**base, grid.get())) {
    return grid_trouble(**base, *trouble);
  }
  Result<DensityGrid> density = density_of(*grid);
  if (!density) return grid_trouble(**base, density.error().message);
  return density;
}

}  // namespace

Result<DensityGrid> import_density(const std::filesystem::path& file, const std::string& grid) {
  return load_from_vdb(file, [&] { return load(file, grid); });
}

}  // namespace ensonify
