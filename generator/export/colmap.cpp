// COLMAP: SSSSSS/images/PPPPPP.png and SSSSSS/sparse/0/{cameras,images,points3D}.txt, by the text
// format of its documentation: world to camera, x to the right, y down and z forward. Pixel
// (0.5, 0.5) is the center of the first one. No points.
#include <fmt/format.h>

#include "export/camera_frames.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// The simplest of COLMAP's models that has all coefficients.
std::string cameras_text(const CameraOptics& o) {
  std::string line = fmt::format("{} {} {} {} {} {}", o.width_px, o.height_px, o.focal_x_px,
                                 o.focal_y_px, o.center_x_px + 0.5, o.center_y_px + 0.5);
  const char* model = !o.is_distorted() ? "PINHOLE" : o.k3 == 0 ? "OPENCV" : "FULL_OPENCV";
  if (o.is_distorted()) line += fmt::format(" {} {} {} {}", o.k1, o.k2, o.p1, o.p2);
  if (o.k3 != 0) line += fmt::format(" {} 0 0 0", o.k3);
  return fmt::format("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 {} {}\n", model, line);
}

// Of an image without observed points, whose line is empty.
std::string image_lines(const CameraFrame& frame, std::uint64_t id) {
  const Quat q = conjugate(frame.camera_in_world.rotation);
  const Vec3 t = rotate(q, -frame.camera_in_world.position_m);
  return fmt::format("{} {} {} {} {} {} {} {} 1 {}.png\n\n", id, q.w, q.x, q.y, q.z, t.x, t.y, t.z,
                     frame.stem);
}

}  // namespace

Status write_colmap(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    const fs::path folder = target / fmt::format("{:06}", sequence.row.sequence);
    const fs::path sparse = folder / "sparse" / "0";
    std::string images =
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
        "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
    std::uint64_t id = 0;
    Status done = for_each_camera_frame(job, sequence, folder / "images", {}, 0,
                                        [&](const CameraFrame& frame) -> Status {
                                          images += image_lines(frame, ++id);
                                          return {};
                                        });
    if (!done) return done;
    done = write_whole(sparse / "cameras.txt", cameras_text(sequence.manifest.info.camera->optics));
    if (done) done = write_whole(sparse / "images.txt", images);
    if (!done) return done;
    return write_whole(
        sparse / "points3D.txt",
        "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
  });
}

}  // namespace ensonify
