#include "world/scene_sdf.h"

#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <openvdb/math/Proximity.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <optional>
#include <sstream>
#include <vector>

#include "world/ground.h"

namespace ensonify {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

constexpr int kFarthestIndex = 1 << 30;
constexpr int kMostSweeps = 8;
constexpr int kLeaf = 8, kLargestBlock = 4096;  // the edges of OpenVDB's nodes

struct Lattice {
  double voxel_m = 0;
  int band_voxels = 0;
  CoordBBox box;  // of the region

  double band_m() const { return voxel_m * band_voxels; }
  float background() const { return static_cast<float>(band_m()); }
};

FloatGrid::Ptr empty_grid(const Lattice& lattice) {
  auto grid = FloatGrid::create(lattice.background());
  grid->setTransform(openvdb::math::Transform::createLinearTransform(lattice.voxel_m));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("sdf");
  return grid;
}

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

// Halves blocks of the lattice down to leaves where a surface is near: the distance changes no
// faster than the position.
struct ClosedFormFiller {
  const Lattice& lattice;
  FloatGrid& grid;
  FloatGrid::Accessor voxels = grid.getAccessor();

  Vec3 place(const Coord& at, double offset = 0) const {
    return lattice.voxel_m * Vec3{at.x() + offset, at.y() + offset, at.z() + offset};
  }

  void leaf(const Solids& solids, const CoordBBox& block) {
    auto* values = voxels.touchLeaf(block.min());
    for (const Coord& at : block) {
      const double d = nearest_m(solids, place(at));
      const float f = static_cast<float>(d);
      if (std::abs(f) < lattice.background()) {
        values->setValueOn(at, f);
      } else {
        values->setValueOff(at, std::copysign(lattice.background(), f));
      }
    }
  }

  void block(const Solids& solids, const Coord& low, int edge) {
    const CoordBBox all = CoordBBox::createCube(low, edge);
    if (!all.hasOverlap(lattice.box)) return;
    const double half = std::numbers::sqrt3 / 2 * (edge - 1) * lattice.voxel_m;
    const Vec3 middle = place(low, (edge - 1) / 2.0);
    const double d = nearest_m(solids, middle);
    if (std::abs(d) > half + lattice.band_m()) {
      if (d < 0) grid.fill(all, -lattice.background(), false);
      return;
    }
    Solids near;
    for (const ClosedFormSolid& solid : solids) {
      if (solid.distance_m(middle) <= d + 2 * half) near.push_back(solid);
    }
    if (edge == kLeaf) return leaf(near, all);
    const int part = edge / 2;
    for (int i = 0; i < 8; ++i) {
      block(near, low.offsetBy((i & 1) * part, (i >> 1 & 1) * part, (i >> 2) * part), part);
    }
  }

  void region(const Solids& solids) {
    const Coord low = lattice.box.min() & ~(kLargestBlock - 1);
    for (int x = low.x(); x <= lattice.box.max().x(); x += kLargestBlock) {
      for (int y = low.y(); y <= lattice.box.max().y(); y += kLargestBlock) {
        for (int z = low.z(); z <= lattice.box.max().z(); z += kLargestBlock) {
          block(solids, {x, y, z}, kLargestBlock);
        }
      }
    }
  }
};

// The interface of meshToVolume, in double: floats would be too coarse far from the origin.
struct IndexTriangles {
  const PlacedTriangles& surface;
  double voxel_m = 0;

  std::size_t polygonCount() const { return surface.triangles.size(); }
  std::size_t pointCount() const { return surface.vertices_m.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t n, std::size_t v, openvdb::Vec3d& at) const {
    const Vec3 p = surface.vertices_m[surface.triangles[n][v]];
    at = openvdb::Vec3d(p.x, p.y, p.z) / voxel_m;
  }
  double distance_m(std::size_t n, const Coord& voxel) const {
    openvdb::Vec3d corner[3], weights;
    for (std::size_t v = 0; v < 3; ++v) getIndexSpacePoint(n, v, corner[v]);
    const openvdb::Vec3d at = voxel.asVec3d();
    return voxel_m * (openvdb::math::closestPointOnTriangleToPoint(corner[0], corner[1], corner[2],
                                                                   at, weights) -
                      at)
                         .length();
  }
};

// OpenVDB searches for the nearest triangle only among those of the preceding voxels, and can miss
// it far from the surface. Here each voxel examines its own triangle and those of all voxels around
// it. Returns false if no voxel found a nearer one.
bool refine(const IndexTriangles& triangles, openvdb::Int32Grid& nearest, FloatGrid& grid) {
  bool changed = false;
  auto numbers = nearest.getAccessor();
  for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) {
    for (auto value = leaf->beginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      openvdb::Int32 last = -1, best = -1;
      double least = std::abs(*value) * (1 - 1e-6);  // float's rounding is no progress
      for (const Coord& around : CoordBBox(at.offsetBy(-1), at.offsetBy(1))) {
        const openvdb::Int32 number = numbers.getValue(around);
        if (number == last || number < 0) continue;
        last = number;
        const double d = triangles.distance_m(static_cast<std::size_t>(number), at);
        if (!(d < least)) continue;
        least = d;
        best = number;
      }
      if (best < 0) continue;
      numbers.setValueOn(at, best);
      value.setValue(std::copysign(static_cast<float>(least), *value));
      changed = true;
    }
  }
  return changed;
}

// Narrows the band. Voxels beyond it get the new background.
void trim(FloatGrid& grid, float background) {
  for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) {
    for (auto value = leaf->beginValueOn(); value; ++value) {
      if (std::abs(*value) < background) continue;
      leaf->setValueOff(value.pos(), std::copysign(background, *value));
    }
  }
  openvdb::tools::changeLevelSetBackground(grid.tree(), background);
}

void add_mesh(const PlacedTriangles& surface, const Lattice& lattice, FloatGrid& scene) {
  if (surface.triangles.empty()) return;
  // OpenVDB proceeds outward from face to face of the voxels, for twice the band less two. It would
  // leave gaps in a band that is oblique to the axes.
  const auto band = static_cast<float>(lattice.band_voxels + 2);
  // Renormalized distances would no longer be distances to the triangles.
  const IndexTriangles triangles{surface, lattice.voxel_m};
  openvdb::Int32Grid nearest(-1);
  auto own = openvdb::tools::meshToVolume<FloatGrid>(
      triangles, scene.transform(), band, band, openvdb::tools::DISABLE_RENORMALIZATION, &nearest);
  for (int sweep = 0; sweep < kMostSweeps && refine(triangles, nearest, *own); ++sweep) {
  }
  trim(*own, lattice.background());
  openvdb::tools::csgUnion(scene, *own);
}

Vec3 widened(Vec3 p, double by_m) { return p + Vec3{by_m, by_m, by_m}; }

PlacedTriangles triangles_of(const MeshShape& shape, const Pose& pose, const SdfGrid& grid,
                             const SdfRegion& region) {
  if (!shape.ground) return placed(*shape.mesh, pose);
  const double margin = (grid.band_voxels + 2) * grid.voxel_m;
  return ground_block(*shape.mesh, pose, widened(region.low_m, -margin),
                      widened(region.high_m, margin));
}

std::optional<Lattice> lattice_of(const SdfGrid& grid, const SdfRegion& region) {
  Lattice lattice{grid.voxel_m, grid.band_voxels, {}};
  const auto index = [&](double m, auto round) { return round(m / grid.voxel_m); };
  const auto down = [](double x) { return std::floor(x); };
  const auto up = [](double x) { return std::ceil(x); };
  const double low[] = {index(region.low_m.x, down), index(region.low_m.y, down),
                        index(region.low_m.z, down)};
  const double high[] = {index(region.high_m.x, up), index(region.high_m.y, up),
                         index(region.high_m.z, up)};
  for (int i = 0; i < 3; ++i) {
    if (!(low[i] >= -kFarthestIndex) || !(high[i] <= kFarthestIndex)) return std::nullopt;
    lattice.box.min()[i] = static_cast<int>(low[i]);
    lattice.box.max()[i] = static_cast<int>(high[i]);
  }
  return lattice;
}

Solids closed_forms_of(const World& world, std::span<const Pose> poses) {
  Solids solids;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const Shape& shape = world.objects[i].shape;
    if (!std::holds_alternative<MeshShape>(shape)) solids.push_back({&shape, poses[i]});
  }
  return solids;
}

FloatGrid::Ptr scene_grid(const World& world, std::span<const Pose> poses, const SdfGrid& spec,
                          const SdfRegion& region, const Lattice& lattice) {
  FloatGrid::Ptr grid = empty_grid(lattice);
  const Solids solids = closed_forms_of(world, poses);
  if (!solids.empty()) ClosedFormFiller{lattice, *grid}.region(solids);
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const auto* mesh = std::get_if<MeshShape>(&world.objects[i].shape);
    if (mesh != nullptr) add_mesh(triangles_of(*mesh, poses[i], spec, region), lattice, *grid);
  }
  grid->clip(lattice.box);
  return grid;
}

// OpenVDB writes random characters after its magic number, three versions and a flag.
std::string without_tag(std::string bytes) {
  constexpr std::size_t kTagAt = 8 + 3 * 4 + 1;
  constexpr std::string_view kNone = "00000000-0000-0000-0000-000000000000";
  const bool there =
      bytes.size() > kTagAt + kNone.size() && bytes[kTagAt + 8] == '-' && bytes[kTagAt + 23] == '-';
  ENSONIFY_ASSERT(there);
  return bytes.replace(kTagAt, kNone.size(), kNone);
}

std::string file_of(const FloatGrid::Ptr& grid) {
  std::ostringstream bytes;
  openvdb::io::Stream stream(bytes);
  // Not every OpenVDB is built with its other compressors.
  stream.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(openvdb::GridCPtrVec{grid});
  return without_tag(std::move(bytes).str());
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
  if (lattice_of(grid, region)) return {};
  return Error{ErrorKind::usage,
               "the sonar's range extends beyond 2^30 voxels from the world's origin; expected "
               "a larger voxel_m"};
}

Result<std::string> scene_sdf_vdb(const World& world, std::span<const Pose> object_in_world,
                                  const SdfGrid& grid, const SdfRegion& region) {
  ENSONIFY_ASSERT(object_in_world.size() == world.objects.size());
  if (Status fits = sdf_fits(world, object_in_world, grid, region); !fits) return fits.error();
  const std::optional<Lattice> lattice = lattice_of(grid, region);
  try {
    // All threads come from core/parallel.h.
    return tbb::task_arena(1).execute([&] {
      openvdb::initialize();
      return file_of(scene_grid(world, object_in_world, grid, region, *lattice));
    });
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::device,
                 "out of memory; use a larger voxel_m, or fewer threads, which make fewer "
                 "sequences at once"};
  }
}

}  // namespace ensonify
