#include "world/scene_sdf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/runtime.h"
#include "world/ground.h"
#include "world/level_set.h"

namespace ensonify {
namespace {

constexpr int kFarthestIndex = 1 << 30;
constexpr int kLeaf = kLevelSetLeaf;

struct ClosedFormSolid {
  const Shape* shape = nullptr;
  Pose pose;

  double distance_m(Vec3 p) const {
    const Vec3 local = inverse_transform_point(pose, p);
    return std::visit(
        [&](const auto& s) {
          if constexpr (std::is_same_v<std::decay_t<decltype(s)>, MeshShape>) {
            return HUGE_VAL;
          } else {
            return signed_distance_m(s, local);
          }
        },
        *shape);
  }
};

using Solids = std::vector<ClosedFormSolid>;

double nearest_m(const Solids& solids, Vec3 p) {
  double least = HUGE_VAL;
  for (const ClosedFormSolid& solid : solids) least = std::min(least, solid.distance_m(p));
  return least;
}

Vec3 widened(Vec3 p, double by_m) { return p + Vec3{by_m, by_m, by_m}; }

PlacedTriangles triangles_of(const MeshShape& shape, const Pose& pose, const SdfGrid& grid,
                             const SdfRegion& region) {
  if (!shape.ground) return placed(*shape.mesh, pose);
  const double margin = (grid.band_voxels + 2) * grid.voxel_m;
  return ground_block(*shape.mesh, pose, widened(region.low_m, -margin),
                      widened(region.high_m, margin));
}

struct VoxelBox {
  std::array<int, 3> low{}, high{};
};

std::optional<VoxelBox> lattice_box(const SdfGrid& grid, const SdfRegion& region) {
  const auto down = [&](double m) { return std::floor(m / grid.voxel_m); };
  const auto up = [&](double m) { return std::ceil(m / grid.voxel_m); };
  const double low[] = {down(region.low_m.x), down(region.low_m.y), down(region.low_m.z)};
  const double high[] = {up(region.high_m.x), up(region.high_m.y), up(region.high_m.z)};
  VoxelBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(low[i] >= -kFarthestIndex) || !(high[i] <= kFarthestIndex)) return std::nullopt;
    box.low[i] = static_cast<int>(low[i]);
    box.high[i] = static_cast<int>(high[i]);
  }
  return box;
}

Solids closed_forms_of(const World& world, std::span<const Pose> poses) {
  Solids solids;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const Shape& shape = world.objects[i].shape;
    if (!std::holds_alternative<MeshShape>(shape)) solids.push_back({&shape, poses[i]});
  }
  return solids;
}

// The number of cubes of the smallest edge whose bounding balls the surface passes through.
double cubes_met(const Solids& solids, Vec3 middle, double edge_m, int halvings) {
  if (std::abs(nearest_m(solids, middle)) > std::numbers::sqrt3 / 2 * edge_m) return 0;
  if (halvings == 0) return 1;
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const auto side = [&](int bit) { return (i >> bit & 1 ? 0.25 : -0.25) * edge_m; };
    sum += cubes_met(solids, middle + Vec3{side(0), side(1), side(2)}, edge_m / 2, halvings - 1);
  }
  return sum;
}

// The area within the cube around the region, estimated from cubes of a sixty-fourth of its edge.
// The surface meets a layer of these that is as thick as their bounding balls, sqrt 3 edges.
double closed_form_area_m2(const Solids& solids, const SdfRegion& region) {
  if (solids.empty()) return 0;
  constexpr int kHalvings = 6;
  const Vec3 size = region.high_m - region.low_m;
  const double edge_m = std::max({size.x, size.y, size.z});
  const double smallest_m = std::ldexp(edge_m, -kHalvings);
  return cubes_met(solids, 0.5 * (region.low_m + region.high_m), edge_m, kHalvings) * smallest_m *
         smallest_m / std::numbers::sqrt3;
}

// The number of leaves of 8^3 floats that the band passes through, for any orientation.
double leaves_of(double area_m2, double voxel_m, int band_voxels) {
  return area_m2 / (kLeaf * kLeaf * voxel_m * voxel_m) * 1.5 * (1 + 2.0 * band_voxels / kLeaf);
}

}  // namespace

SdfSize sdf_size(const World& world, std::span<const Pose> object_in_world, const SdfGrid& grid,
                 const SdfRegion& region) {
  constexpr double kLeafBytes = 2300;
  double meshes = 0;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const auto* mesh = std::get_if<MeshShape>(&world.objects[i].shape);
    if (mesh != nullptr) meshes += area_m2(triangles_of(*mesh, object_in_world[i], grid, region));
  }
  const double forms = closed_form_area_m2(closed_forms_of(world, object_in_world), region);
  const auto voxels_of = [&](double area) {
    return area / (grid.voxel_m * grid.voxel_m) * 2 * grid.band_voxels;
  };
  // The factors were measured with voxels of 0.16 to 0.01 m. The file grows in memory before it is
  // written.
  const double mesh_file = 3 * voxels_of(meshes), form_file = 8 * voxels_of(forms);
  SdfSize size;
  size.voxels = voxels_of(meshes + forms);
  size.file_bytes = mesh_file + form_file;
  // While the field of a mesh is made, it has a wider band and a grid of triangle numbers.
  size.memory_bytes = kLeafBytes * (leaves_of(meshes + forms, grid.voxel_m, grid.band_voxels) +
                                    2 * leaves_of(meshes, grid.voxel_m, grid.band_voxels + 2)) +
                      2 * mesh_file + 6 * form_file;
  return size;
}

Status sdf_fits(const World& world, std::span<const Pose> object_in_world, const SdfGrid& grid,
                const SdfRegion& region) {
  const double voxels = sdf_size(world, object_in_world, grid, region).voxels;
  if (voxels > kMaxSdfVoxels) {
    return Error{
        ErrorKind::usage,
        fmt::format("gives about {:.2g} voxels near surfaces; expected at most {:.2g}: use "
                    "{:.2g} m or more, a smaller band_voxels or a shorter range",
                    voxels, kMaxSdfVoxels,
                    grid.voxel_m * std::sqrt(voxels / kMaxSdfVoxels) * 1.05)};
  }
  if (lattice_box(grid, region)) return {};
  return Error{ErrorKind::usage,
               "the sonar's range extends beyond 2^30 voxels from the world's origin; expected "
               "a larger voxel_m"};
}

Result<std::string> scene_sdf_vdb(const World& world, std::span<const Pose> object_in_world,
                                  const SdfGrid& grid, const SdfRegion& region) {
  ENSONIFY_ASSERT(object_in_world.size() == world.objects.size());
  if (Status fits = sdf_fits(world, object_in_world, grid, region); !fits) return fits.error();
  static const Result<void*> entry =
      module_symbol(companion_path(kLevelSetModule), kLevelSetEntry,
                    "install OpenVDB (Debian: apt-get install libopenvdb-dev)");
  if (!entry) return entry.error();
  const Solids solids = closed_forms_of(world, object_in_world);
  std::vector<std::size_t> meshes;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    if (std::holds_alternative<MeshShape>(world.objects[i].shape)) meshes.push_back(i);
  }
  const VoxelBox box = *lattice_box(grid, region);
  const LevelSetTask task{
      grid.voxel_m,
      grid.band_voxels,
      box.low,
      box.high,
      solids.size(),
      meshes.size(),
      [&](std::size_t solid, Vec3 point_m) { return solids[solid].distance_m(point_m); },
      [&](std::size_t mesh) {
        const std::size_t i = meshes[mesh];
        return triangles_of(std::get<MeshShape>(world.objects[i].shape), object_in_world[i], grid,
                            region);
      }};
  std::string bytes;
  if (reinterpret_cast<LevelSetEntry>(*entry)(task, bytes)) return bytes;
  return Error{ErrorKind::device,
               "out of memory; use a larger voxel_m, or fewer threads, which make fewer sequences "
               "at once"};
}

}  // namespace ensonify
