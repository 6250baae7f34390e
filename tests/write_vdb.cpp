#include "write_vdb.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>

#include <cmath>
#include <memory>

namespace ensonify::test {
namespace {

openvdb::math::Transform::Ptr transform_of(const VdbGrid& grid) {
  if (grid.frustum) {
    return openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 1.0, grid.voxel_m);
  }
  auto transform = openvdb::math::Transform::createLinearTransform(grid.voxel_m);
  if (grid.mirrored) transform->preScale(openvdb::Vec3d(-1, 1, 1));
  transform->postTranslate({grid.offset_m[0], grid.offset_m[1], grid.offset_m[2]});
  return transform;
}

void fill_distances(const VdbGrid& spec, openvdb::FloatGrid& grid) {
  const double band = 3 * spec.voxel_m;
  auto voxels = grid.getAccessor();
  const openvdb::CoordBBox all(openvdb::Coord(-spec.extent), openvdb::Coord(spec.extent));
  for (const openvdb::Coord& at : all) {
    const double d =
        spec.distance_m(at.x() * spec.voxel_m, at.y() * spec.voxel_m, at.z() * spec.voxel_m);
    if (std::abs(d) < band) voxels.setValueOn(at, static_cast<float>(d));
  }
  openvdb::tools::signedFloodFill(grid.tree());
}

// Grids come out of the library's own factory. A grid that is constructed here would have the
// compiler instantiate all virtual functions of its tree, which takes half a minute.
openvdb::FloatGrid::Ptr empty_grid(float background) {
  const auto grid = openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType());
  auto typed = std::static_pointer_cast<openvdb::FloatGrid>(grid);
  typed->tree().root().setBackground(background, false);
  return typed;
}

openvdb::GridBase::Ptr made_floats(const VdbGrid& spec) {
  if (spec.distance_m) {
    auto grid = empty_grid(static_cast<float>(3 * spec.voxel_m));
    fill_distances(spec, *grid);
    return grid;
  }
  auto grid = empty_grid(spec.background);
  for (const VdbBox& box : spec.boxes) {
    const openvdb::CoordBBox region({box.low[0], box.low[1], box.low[2]},
                                    {box.high[0], box.high[1], box.high[2]});
    grid->tree().fill(region, box.value, true);  // with tiles where it can
  }
  return grid;
}

openvdb::GridBase::Ptr made(const VdbGrid& spec) {
  const auto grid = spec.kind == VdbKind::doubles
                        ? openvdb::GridBase::createGrid(openvdb::DoubleGrid::gridType())
                    : spec.kind == VdbKind::vectors
                        ? openvdb::GridBase::createGrid(openvdb::Vec3SGrid::gridType())
                        : made_floats(spec);
  grid->setName(spec.name);
  grid->setTransform(transform_of(spec));
  grid->setGridClass(spec.kind == VdbKind::level_set ? openvdb::GRID_LEVEL_SET
                                                     : openvdb::GRID_FOG_VOLUME);
  return grid;
}

}  // namespace

VdbGrid vdb_sphere(double radius_m, double voxel_m) {
  VdbGrid grid;
  grid.name = "ball";
  grid.voxel_m = voxel_m;
  grid.kind = VdbKind::level_set;
  grid.extent = static_cast<int>(radius_m / voxel_m) + 5;
  grid.distance_m = [=](double x, double y, double z) { return std::hypot(x, y, z) - radius_m; };
  return grid;
}

void write_vdb(const std::filesystem::path& file, const std::vector<VdbGrid>& grids) {
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  openvdb::initialize();
  openvdb::GridPtrVec all;
  for (const VdbGrid& grid : grids) all.push_back(made(grid));
  openvdb::io::File out(file.string());
  out.write(all);
  out.close();
}

}  // namespace ensonify::test
