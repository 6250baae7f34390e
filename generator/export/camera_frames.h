// What exporters of a camera's images share. Private to export/.
//
//   CameraFrame  for_each_camera_frame   the images of a sequence, copied, with their poses
//   rotation_rows
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include "core/camera.h"
#include "export/job.h"

namespace ensonify {

struct CameraFrame {
  const StoredPing& ping;
  Pose camera_in_world;
  std::string stem;  // of the files: 000000, the ping
};

// Copies the colors of every exported ping to `images`/STEM.png and, where `depths` is not empty,
// writes depth times `units_per_m` to `depths`/STEM.png. Errors (usage): the sequence has no
// camera, or no files of its colors or depth.
Status for_each_camera_frame(const ExportJob& job, const StoredSequence& sequence,
                             const std::filesystem::path& images,
                             const std::filesystem::path& depths, double units_per_m,
                             const std::function<Status(const CameraFrame&)>& use);

// The rotation as a matrix, row by row.
std::array<Vec3, 3> rotation_rows(Quat rotation);

}  // namespace ensonify
