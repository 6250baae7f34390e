// The signed distance field of a world's solid objects.
//
//   SdfRegion          the box to compute it in
//   sdf_size           its size and memory
//   sdf_fits           whether this size is allowed
//   scene_sdf_vdb      as an OpenVDB file
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/error.h"
#include "core/ping.h"
#include "world/world.h"

namespace ensonify {

struct SdfRegion {
  Vec3 low_m, high_m;  // in the world
};

// Estimated from the area of the surfaces.
struct SdfSize {
  double voxels = 0;        // within the band
  double memory_bytes = 0;  // while it is made
  double file_bytes = 0;
};
SdfSize sdf_size(const World& world, std::span<const Pose> object_in_world, const SdfGrid& grid,
                 const SdfRegion& region);

inline constexpr double kMaxSdfVoxels = 2147483648.0;

// Errors (usage): more than kMaxSdfVoxels, or a region beyond 2^30 voxels from the world's origin.
Status sdf_fits(const World& world, std::span<const Pose> object_in_world, const SdfGrid& grid,
                const SdfRegion& region);

// The bytes of an OpenVDB file with one level set of floats, `sdf`, cubic voxels, voxel i with its
// middle at i voxel_m of the world. The field is the least distance to all objects at the poses
// `object_in_world` (one per object). It is exact outside of all objects, and inside of an object
// that meets no other; where solids overlap, its magnitude is too small. Closed forms use their
// formulas, to float rounding. Meshes and models use their triangles; their inside is the space
// from which no path leads out, and a mesh that is not closed is unsigned. Terrain is a block that
// ends below the region. Active voxels are those nearer than band_voxels to a surface; the others
// hold +- the band's width. No voxel is active outside of the region. Equal input gives equal
// bytes. Uses one thread. Errors: those of sdf_fits; (device) out of memory.
Result<std::string> scene_sdf_vdb(const World& world, std::span<const Pose> object_in_world,
                                  const SdfGrid& grid, const SdfRegion& region);

}  // namespace ensonify
