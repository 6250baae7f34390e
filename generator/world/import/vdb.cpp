// OpenVDB files: density grids and level sets.
#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>

#include "world/import/import.h"

namespace ensonify {
namespace {

using openvdb::FloatGrid;

// Coordinates up to this limit do not overflow.
constexpr int kFarthestVdbIndex = 1 << 30;
constexpr float kMaxDensity = 1e6f;

Error usage(const std::string& trouble) { return {ErrorKind::usage, trouble}; }

std::string names_in(const openvdb::GridPtrVec& grids) {
  std::string names;
  for (const auto& grid : grids) {
    names += (names.empty() ? "" : ", ") + grid->getName();
    if (names.size() > 300) return names + ", ...";
  }
  return names.empty() ? "none" : names;
}

// Reads one grid of the file by its name, or the only grid if `name` is empty. Throws the
// exceptions of OpenVDB.
Result<openvdb::GridBase::Ptr> read_grid(const std::filesystem::path& path,
                                         const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(false);
  if (!name.empty() && file.hasGrid(name)) return file.readGrid(name);
  const openvdb::GridPtrVec grids = *file.readAllGridMetadata();
  if (name.empty() && grids.size() == 1) return file.readGrid(grids[0]->getName());
  if (name.empty()) {
    return usage(
        fmt::format("holds {} grids; set `grid` to one of {}", grids.size(), names_in(grids)));
  }
  return usage(fmt::format("has no grid `{}`; expected one of {}", name, names_in(grids)));
}

bool is_near_origin(const openvdb::CoordBBox& box) {
  for (int i = 0; i < 3; ++i) {
    if (box.min()[i] < -kFarthestVdbIndex || box.max()[i] > kFarthestVdbIndex) return false;
  }
  return true;
}

// Requirements for a grid. Each function returns what is wrong, or an empty text.
struct GridDemands {
  std::string (*kind)(openvdb::GridClass kind);
  std::string (*background)(float value);
  std::string (*value)(float value);
};

std::string trouble_of(const openvdb::GridBase& base, const FloatGrid* grid,
                       const GridDemands& demands) {
  if (grid == nullptr) {
    return fmt::format("holds {}; expected a grid of float", base.valueType());
  }
  const openvdb::GridClass kind = base.getGridClass();
  if (kind != openvdb::GRID_UNKNOWN) {
    if (std::string trouble = demands.kind(kind); !trouble.empty()) return trouble;
  }
  if (!base.transform().isLinear()) return "is not a regular grid; expected a linear transform";
  if (std::string trouble = demands.background(grid->background()); !trouble.empty()) {
    return trouble;
  }
  if (grid->activeVoxelCount() == 0) {
    return "has no active voxels; expected at least one";
  }
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    if (std::string trouble = demands.value(*value); !trouble.empty()) return trouble;
  }
  if (is_near_origin(grid->evalActiveVoxelBoundingBox())) return "";
  return fmt::format("has voxels beyond index {}; expected a grid nearer to its origin",
                     kFarthestVdbIndex);
}

// Reads a grid that meets the demands and passes it to `make`, whose errors get the name of the
// grid. All errors get the name of the file, and exceptions of OpenVDB become errors. Everything
// runs on this thread, because all threads come from core/parallel.h, and OpenVDB would start
// others to count and to free memory.
template <class T>
Result<T> load_from_vdb(const std::filesystem::path& file, const std::string& name,
                        const GridDemands& demands, Result<T> (*make)(const FloatGrid&)) {
  const auto refuse = [&](const std::string& trouble) {
    return usage(fmt::format("{}: {}", file.string(), trouble));
  };
  try {
    Result<T> loaded = tbb::task_arena(1).execute([&]() -> Result<T> {
      Result<openvdb::GridBase::Ptr> base = read_grid(file, name);
      if (!base) return base.error();
      const auto grid = openvdb::gridPtrCast<FloatGrid>(*base);
      const auto named = [&](const std::string& trouble) {
        return usage(fmt::format("grid `{}` {}", (*base)->getName(), trouble));
      };
      const std::string trouble = trouble_of(**base, grid.get(), demands);
      if (!trouble.empty()) return named(trouble);
      Result<T> made = make(*grid);
      return made ? std::move(made) : Result<T>(named(made.error().message));
    });
    return loaded ? std::move(loaded) : Result<T>(refuse(loaded.error().message));
  } catch (const std::bad_alloc&) {
    throw;  // main.cpp's
  } catch (const std::exception& e) {
    std::string what = e.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    return refuse(fmt::format("cannot be read ({}); expected an OpenVDB file", what));
  }
}

const GridDemands kDensityDemands = {
    [](openvdb::GridClass kind) {
      return kind == openvdb::GRID_FOG_VOLUME
                 ? ""
                 : fmt::format("is a {}; expected a fog volume, whose values are densities",
                               openvdb::GridBase::gridClassToString(kind));
    },
    [](float value) {
      return value == 0 ? ""
                        : fmt::format(
                              "has the background {}; expected 0, as the density must end "
                              "somewhere",
                              value);
    },
    [](float value) {
      return value >= 0 && value <= kMaxDensity
                 ? ""
                 : fmt::format("holds the density {}; expected 0 to {}", value, kMaxDensity);
    }};

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

Result<DensityGrid> density_of(const FloatGrid& grid) {
  const Affine affine = index_from_world(grid.transform());
  const openvdb::Vec3d size = grid.voxelSize();
  const double spacing_m = std::min({size[0], size[1], size[2]});
  if (!(spacing_m > 0) || !is_finite(affine)) {
    return usage("has voxels of size 0; expected a size above 0");
  }
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  FloatGrid::ConstAccessor voxels = grid.getConstAccessor();
  DensitySource source;
  source.low = {box.min()[0], box.min()[1], box.min()[2]};
  source.high = {box.max()[0], box.max()[1], box.max()[2]};
  // A brick's samples lie in up to eight leaves, which have the size of a brick.
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

const GridDemands kLevelSetDemands = {
    [](openvdb::GridClass kind) -> std::string {
      if (kind == openvdb::GRID_FOG_VOLUME) {
        return "is a fog volume; expected a level set: densities belong under volumes, vdb";
      }
      return kind == openvdb::GRID_LEVEL_SET
                 ? ""
                 : fmt::format("is a {}; expected a level set, whose values are distances",
                               openvdb::GridBase::gridClassToString(kind));
    },
    [](float value) {
      return value > 0 ? ""
                       : fmt::format(
                             "has the background {}; expected a distance above 0, as inside "
                             "is negative",
                             value);
    },
    [](float value) -> std::string {
      return std::isfinite(value) ? ""
                                  : "holds a distance that is not finite; expected finite numbers";
    }};

// Whether the transform mirrors.
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
    for (int k = 0; k < 3; ++k) corner[k] = to_vec3(mesh.vertices[triangle[k]]);
    const Vec3 area = cross(corner[1] - corner[0], corner[2] - corner[0]);
    for (const std::uint32_t v : triangle) sums[v] = sums[v] + area;
  }
  for (const Vec3& sum : sums) {
    mesh.normals.push_back(to_floats(length(sum) > 0 ? normalized(sum) : Vec3{}));
  }
}

Result<Mesh> surface_of(const FloatGrid& grid) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads);
  Mesh mesh;
  mesh.vertices.reserve(points.size());
  for (const openvdb::Vec3s& p : points) {
    if (!std::isfinite(p.x()) || !std::isfinite(p.y()) || !std::isfinite(p.z())) {
      return usage("has a surface with points that are not finite");
    }
    mesh.vertices.push_back({p.x(), p.y(), p.z()});
  }
  // OpenVDB's faces are clockwise as seen from outside.
  const bool turned = !is_mirrored(grid.transform());
  mesh.triangles.reserve(2 * quads.size());
  for (openvdb::Vec4I q : quads) {
    if (turned) std::swap(q[1], q[3]);
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  // Voxels that the surface only touches leave slivers. Dropping these opens no gap.
  drop_faces_without_area(mesh);
  mesh.warnings.clear();
  if (mesh.triangles.empty()) {
    return usage("has no surface; expected distances of both signs");
  }
  return mesh;
}

}  // namespace

Result<DensityGrid> import_density(const std::filesystem::path& file, const std::string& grid) {
  return load_from_vdb(file, grid, kDensityDemands, density_of);
}

Result<Mesh> import_level_set(const std::filesystem::path& file, const std::string& grid,
                              Normals normals) {
  Result<Mesh> mesh = load_from_vdb(file, grid, kLevelSetDemands, surface_of);
  if (!mesh) return mesh;
  if (Status possible = check_extent(*mesh, file); !possible) return possible.error();
  if (normals == Normals::smooth) add_smooth_normals(*mesh);
  return mesh;
}

}  // namespace ensonify
