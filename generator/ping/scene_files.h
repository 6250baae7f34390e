// Files of a sequence that show its scene at the first ping: distance field, meshes, height map.
//
//   check_scene_files            whether the selected ones can be made
//   SceneFileSizes  scene_file_sizes    their bytes, on disk and in memory
//   scene_sdf  scene_meshes
//   height_map_grid  scene_heights
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "ping/session.h"
#include "trace/tracer.h"
#include "world/scene_mesh.h"

namespace ensonify {

inline constexpr std::uint64_t kMostHeights = 100'000'000;

// Errors (usage): those of sdf_fits and scene_fits; a height map of more than kMostHeights points.
Status check_scene_files(const Session& session);

// Of one sequence, all pings of the trajectory included. The height map on disk is not in them,
// because it counts with the arrays of the catalogue.
struct SceneFileSizes {
  double file_bytes = 0;
  double memory_bytes = 0;  // while they are made
};
SceneFileSizes scene_file_sizes(const Session& session);

// The bytes of sdf.vdb; empty if it is not selected. Errors: those of scene_sdf_vdb.
Result<std::string> scene_sdf(const Session& session, const SequenceInfo& info);

// Of output.world; empty if it is not selected. The session must outlive it.
std::vector<SceneObject> scene_meshes(const Session& session, const SequenceInfo& info);

// The grid over the rectangle around the fans of all pings of the trajectory: from the sonar to
// range_max_m within the beam cells and the vertical fan. Its points are multiples of the spacing,
// and the outer ones lie on the rectangle or beyond it.
HeightMap height_map_grid(const Session& session);

// [rows x columns] of info.height_map: the highest surface of the objects below the reach of the
// sonar, from vertical rays; NaN where none lies within range_max_m above or below the positions of
// the sonar. Rooms are open from above. Error: that of `go_on`, which is asked between rows.
Result<std::vector<float>> scene_heights(const Session& session, const Tracer& tracer,
                                         const SequenceInfo& info, const Workers& workers,
                                         const std::function<Status()>& go_on);

}  // namespace ensonify
