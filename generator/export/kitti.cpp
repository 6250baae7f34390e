// KITTI odometry: sequences/SS/image_2/PPPPPP.png, calib.txt and times.txt, and poses/SS.txt, by
// the development kit: the camera relative to its first place, x to the right, y down and z
// forward. depth_2/PPPPPP.png has 256 times the depth, as KITTI's depth benchmark.
#include <fmt/format.h>

#include <optional>

#include "export/camera_frames.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr double kKittiUnitsPerM = 256;

std::string calib_text(const CameraOptics& o) {
  std::string text;
  for (int camera = 0; camera < 4; ++camera) {
    text += fmt::format("P{}: {:e} 0 {:e} 0 0 {:e} {:e} 0 0 0 1 0\n", camera, o.focal_x_px,
                        o.center_x_px, o.focal_y_px, o.center_y_px);
  }
  return text;
}

std::string pose_line(const Pose& first, const Pose& camera) {
  const auto rows = rotation_rows(conjugate(first.rotation) * camera.rotation);
  const Vec3 p = inverse_transform_point(first, camera.position_m);
  return fmt::format("{:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e}\n", rows[0].x,
                     rows[0].y, rows[0].z, p.x, rows[1].x, rows[1].y, rows[1].z, p.y, rows[2].x,
                     rows[2].y, rows[2].z, p.z);
}

}  // namespace

Status write_kitti(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    const auto& camera = sequence.manifest.info.camera;
    if (camera && camera->optics.is_distorted()) {
      return Error{ErrorKind::usage,
                   fmt::format("sequence {}: the camera's images are distorted, but this layout "
                               "holds rectified ones; expected a camera without distortion",
                               sequence.row.sequence)};
    }
    const std::string name = fmt::format("{:02}", sequence.row.sequence);
    const fs::path folder = target / "sequences" / name;
    std::optional<Pose> first;
    double first_s = 0;
    std::string times, poses;
    Status done = for_each_camera_frame(job, sequence, folder / "image_2", folder / "depth_2",
                                        kKittiUnitsPerM, [&](const CameraFrame& frame) -> Status {
                                          if (!first) {
                                            first = frame.camera_in_world;
                                            first_s = frame.ping.time_s;
                                          }
                                          times +=
                                              fmt::format("{:e}\n", frame.ping.time_s - first_s);
                                          poses += pose_line(*first, frame.camera_in_world);
                                          return {};
                                        });
    if (done) done = write_whole(folder / "times.txt", times);
    if (done) done = write_whole(folder / "calib.txt", calib_text(camera->optics));
    return done ? write_whole(target / "poses" / (name + ".txt"), poses) : done;
  });
}

}  // namespace ensonify
