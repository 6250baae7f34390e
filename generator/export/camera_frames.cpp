#include "export/camera_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

const CatalogueRow& camera_row(std::string_view plane) {
  const CatalogueRow* row = find_array("camera_" + std::string(plane) + ".npy");
  ENSONIFY_ASSERT(row != nullptr);
  return *row;
}

// 0: no surface, or one too far away for 16 bits.
Status write_depth(const ExportJob& job, const StoredSequence& sequence, const StoredPing& ping,
                   double units_per_m, const fs::path& target) {
  CellReader reader(job.dataset, sequence, ping.ping);
  const auto bytes = reader.read(camera_row("depth_m"));
  if (!bytes) return bytes.error();
  std::vector<std::uint16_t> pixels;
  for (const float depth_m : values_in<float>(*bytes)) {
    const double units = std::round(static_cast<double>(depth_m) * units_per_m);
    pixels.push_back(units > 0 && units < 65536 ? static_cast<std::uint16_t>(units) : 0);
  }
  const CameraOptics& optics = sequence.manifest.info.camera->optics;
  const auto png = encode_png(pixels, optics.height_px, optics.width_px);
  return png ? write_whole(target, *png) : Status(png.error());
}

}  // namespace

Status for_each_camera_frame(const ExportJob& job, const StoredSequence& sequence,
                             const fs::path& images, const fs::path& depths, double units_per_m,
                             const std::function<Status(const CameraFrame&)>& use) {
  const CatalogueRow& color = camera_row("color");
  if (const Status there = need(job, sequence, color); !there) return there;
  if (!depths.empty()) {
    if (const Status there = need(job, sequence, camera_row("depth_m")); !there) return there;
  }
  if (!sequence.manifest.info.camera) {
    return damaged(
        job.dataset.dir / layout::in_sequence(sequence.row.sequence, layout::kSequenceJson),
        "has no member camera for the camera's files");
  }
  return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const CameraFrame frame{ping,
                            compose(ping.sonar_in_world, sequence.manifest.info.camera->in_sonar),
                            layout::ping_stem(ping.ping)};
    const auto file = path_of(job, sequence, ping, color);
    if (!file) return file.error();
    Status done = copy_whole(*file, images / (frame.stem + ".png"));
    if (done && !depths.empty()) {
      done = write_depth(job, sequence, ping, units_per_m, depths / (frame.stem + ".png"));
    }
    return done ? use(frame) : done;
  });
}

std::array<Vec3, 3> rotation_rows(Quat rotation) {
  const Vec3 x = rotate(rotation, {1, 0, 0}), y = rotate(rotation, {0, 1, 0}),
             z = rotate(rotation, {0, 0, 1});
  return {Vec3{x.x, y.x, z.x}, Vec3{x.y, y.y, z.y}, Vec3{x.z, y.z, z.z}};
}

}  // namespace ensonify
