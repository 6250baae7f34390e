// What OpenVDB does for scene_sdf.h. It is in a module, libensonify_sdf.so, since linking OpenVDB
// takes three quarters of the time in which the program starts.
//
//   LevelSetTask            closed forms and meshes on a lattice
//   LevelSetEntry  kLevelSetModule  kLevelSetEntry     the module's function
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>

#include "core/vec.h"
#include "world/ground.h"

namespace ensonify {

inline constexpr int kLevelSetLeaf = 8;  // the edge of OpenVDB's leaves, in voxels

// Voxel i has its middle at i voxel_m.
struct LevelSetTask {
  double voxel_m = 0;
  int band_voxels = 0;
  std::array<int, 3> low{}, high{};  // the first and the last voxel of the region
  std::size_t solids = 0, meshes = 0;
  std::function<double(std::size_t solid, Vec3 point_m)> distance_m;  // signed
  std::function<PlacedTriangles(std::size_t mesh)> triangles;
};

inline constexpr char kLevelSetModule[] = "libensonify_sdf.so";
inline constexpr char kLevelSetEntry[] = "ensonify_level_set";

// Writes an OpenVDB file with the union of all into `bytes`. False: out of memory.
using LevelSetEntry = bool (*)(const LevelSetTask& task, std::string& bytes);

}  // namespace ensonify
