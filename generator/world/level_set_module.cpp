// The module libensonify_sdf.so: level sets by OpenVDB.
#include "world/level_set.h"

#include <openvdb/io/Stream.h>
#include <openvdb/math/Proximity.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <numeric>
#include <sstream>
#include <vector>

namespace ensonify {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

constexpr int kMostSweeps = 8;
constexpr int kLeaf = kLevelSetLeaf, kLargestBlock = 4096;  // the edges of nodes

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

using Solids = std::vector<std::size_t>;  // numbers of closed forms

// Halves blocks of the lattice down to leaves where a surface is near: the distance changes no
// faster than the position.
struct ClosedFormFiller {
  const LevelSetTask& task;
  const Lattice& lattice;
  FloatGrid& grid;
  FloatGrid::Accessor voxels = grid.getAccessor();

  Vec3 place(const Coord& at, double offset = 0) const {
    return lattice.voxel_m * Vec3{at.x() + offset, at.y() + offset, at.z() + offset};
  }

  double nearest_m(const Solids& solids, Vec3 point_m) const {
    double least = HUGE_VAL;
    for (const std::size_t solid : solids) least = std::min(least, task.distance_m(solid, point_m));
    return least;
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
    for (const std::size_t solid : solids) {
      if (task.distance_m(solid, middle) <= d + 2 * half) near.push_back(solid);
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

// Triangles in voxels from `origin`, a multiple of a leaf's edge near the region: far from it the
// floats of meshToVolume would be too coarse.
struct IndexTriangles {
  const PlacedTriangles& surface;
  double voxel_m = 0;
  Coord origin;

  openvdb::Vec3d point(std::size_t n) const {
    const Vec3 p = surface.vertices_m[n];
    return openvdb::Vec3d(p.x, p.y, p.z) / voxel_m - origin.asVec3d();
  }
  double distance_m(std::size_t n, const Coord& voxel) const {
    openvdb::Vec3d corner[3], weights;
    for (std::size_t v = 0; v < 3; ++v) corner[v] = point(surface.triangles[n][v]);
    const openvdb::Vec3d at = voxel.asVec3d();
    return voxel_m * (openvdb::math::closestPointOnTriangleToPoint(corner[0], corner[1], corner[2],
                                                                   at, weights) -
                      at)
                         .length();
  }
};

// OpenVDB searches for the nearest triangle only among those of the preceding voxels, and can miss
// it far from the surface. Here each voxel examines its own triangle and those of all voxels around
// it, in double: the first time it replaces OpenVDB's distance. Returns false if no voxel found a
// nearer one.
bool refine(const IndexTriangles& triangles, bool first, openvdb::Int32Grid& nearest,
            FloatGrid& grid) {
  bool changed = false;
  auto numbers = nearest.getAccessor();
  for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) {
    for (auto value = leaf->beginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      openvdb::Int32 last = -1, best = -1;
      // Float's rounding is no progress.
      double least = first ? HUGE_VAL : std::abs(*value) * (1 - 1e-6);
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

// The library has meshToVolume compiled for these types alone, and compiling it is half of this
// module's time.
FloatGrid::Ptr distances(const IndexTriangles& triangles, const FloatGrid& like, float band,
                         openvdb::Int32Grid& nearest) {
  std::vector<openvdb::Vec3s> points;
  points.reserve(triangles.surface.vertices_m.size());
  for (std::size_t n = 0; n < triangles.surface.vertices_m.size(); ++n) {
    points.emplace_back(triangles.point(n));
  }
  std::vector<openvdb::Vec3I> corners;
  corners.reserve(triangles.surface.triangles.size());
  for (const auto& triangle : triangles.surface.triangles) {
    corners.emplace_back(triangle[0], triangle[1], triangle[2]);
  }
  openvdb::util::NullInterrupter never;
  // Renormalized distances would no longer be distances to the triangles.
  return openvdb::tools::meshToVolume<FloatGrid>(
      never,
      openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I>(points, corners),
      like.transform(), band, band, openvdb::tools::DISABLE_RENORMALIZATION, &nearest);
}

void add_mesh(const PlacedTriangles& surface, const Lattice& lattice, FloatGrid& scene) {
  if (surface.triangles.empty()) return;
  // OpenVDB proceeds outward from face to face of the voxels, for twice the band less two. It would
  // leave gaps in a band that is oblique to the axes.
  const auto band = static_cast<float>(lattice.band_voxels + 2);
  const Coord origin = lattice.box.min() & ~(kLeaf - 1);
  const IndexTriangles triangles{surface, lattice.voxel_m, origin};
  openvdb::Int32Grid nearest(-1);
  const auto near_origin = distances(triangles, scene, band, nearest);
  for (int sweep = 0; sweep < kMostSweeps && refine(triangles, sweep == 0, nearest, *near_origin);
       ++sweep) {
  }
  trim(*near_origin, lattice.background());
  std::vector<FloatGrid::TreeType::LeafNodeType*> leaves;
  near_origin->tree().stealNodes(leaves);
  auto own = empty_grid(lattice);
  for (auto* leaf : leaves) {
    leaf->setOrigin(leaf->origin() + origin);
    own->tree().addLeaf(leaf);
  }
  openvdb::tools::signedFloodFill(own->tree());
  openvdb::tools::csgUnion(scene, *own);
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

FloatGrid::Ptr scene_grid(const LevelSetTask& task) {
  const CoordBBox box(Coord(task.low.data()), Coord(task.high.data()));
  const Lattice lattice{task.voxel_m, task.band_voxels, box};
  FloatGrid::Ptr grid = empty_grid(lattice);
  Solids solids(task.solids);
  std::iota(solids.begin(), solids.end(), std::size_t{0});
  if (!solids.empty()) ClosedFormFiller{task, lattice, *grid}.region(solids);
  for (std::size_t i = 0; i < task.meshes; ++i) add_mesh(task.triangles(i), lattice, *grid);
  grid->clip(box);
  return grid;
}

}  // namespace
}  // namespace ensonify

extern "C" bool ensonify_level_set(const ensonify::LevelSetTask& task, std::string& bytes) {
  try {
    // All threads come from core/parallel.h.
    tbb::task_arena(1).execute([&] {
      openvdb::initialize();
      bytes = ensonify::file_of(ensonify::scene_grid(task));
    });
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}
