// nerfstudio: SSSSSS/transforms.json, images/PPPPPP.png and depths/PPPPPP.png in millimeters, by
// the data conventions of its documentation: camera to world, x to the right, y up and z backward.
// Pixel (0.5, 0.5) is the center of the first one.
#include <fmt/format.h>

#include "export/camera_frames.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr double kMillimetersPerM = 1000;

Json head_json(const CameraOptics& optics) {
  return {{"camera_model", "OPENCV"},
          {"w", optics.width_px},
          {"h", optics.height_px},
          {"fl_x", optics.focal_x_px},
          {"fl_y", optics.focal_y_px},
          {"cx", optics.center_x_px + 0.5},
          {"cy", optics.center_y_px + 0.5},
          {"k1", optics.k1},
          {"k2", optics.k2},
          {"k3", optics.k3},
          {"p1", optics.p1},
          {"p2", optics.p2},
          {"depth_unit_scale_factor", 1 / kMillimetersPerM},
          {"frames", Json::array()}};
}

Json frame_json(const CameraFrame& frame) {
  Json matrix = Json::array();
  const auto rows = rotation_rows(frame.camera_in_world.rotation);
  const Vec3 p = frame.camera_in_world.position_m;
  const double place[] = {p.x, p.y, p.z};
  for (std::size_t i = 0; i < 3; ++i) {
    matrix.push_back({rows[i].x, -rows[i].y, -rows[i].z, place[i]});
  }
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  return {{"file_path", "images/" + frame.stem + ".png"},
          {"depth_file_path", "depths/" + frame.stem + ".png"},
          {"time", frame.ping.time_s},
          {"transform_matrix", std::move(matrix)}};
}

}  // namespace

Status write_nerfstudio(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    const fs::path folder = target / fmt::format("{:06}", sequence.row.sequence);
    Json frames = Json::array();
    const Status read =
        for_each_camera_frame(job, sequence, folder / "images", folder / "depths", kMillimetersPerM,
                              [&](const CameraFrame& frame) -> Status {
                                frames.push_back(frame_json(frame));
                                return {};
                              });
    if (!read) return read;
    Json json = head_json(sequence.manifest.info.camera->optics);
    json["frames"] = std::move(frames);
    return write_whole(folder / "transforms.json", json_text(json));
  });
}

}  // namespace ensonify
