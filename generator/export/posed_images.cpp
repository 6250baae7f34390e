#include "export/posed_images.h"

#include <algorithm>
#include <cmath>

namespace ensonify {

Result<DatasetScale> scale_of_dataset(const ExportJob& job) {
  const auto first = read_sequence(job.dataset, job.dataset.sequences.front());
  if (!first) return first.error();
  const auto full_scale_db = full_scale_of(job, *first);
  if (!full_scale_db) return full_scale_db.error();
  return DatasetScale{*full_scale_db};
}

Result<std::vector<float>> scaled_amplitudes(const ExportJob& job, const StoredSequence& sequence,
                                             std::uint32_t ping, const DatasetScale& scale) {
  auto read = log_ping_of(job, sequence, ping, false);
  if (!read) return read.error();
  for (float& value : read->level_db) {
    value = static_cast<float>(std::min(1.0, std::pow(10, (value - scale.full_scale_db) / 20)));
  }
  return std::move(read->level_db);
}

std::array<double, 16> matrix_of(const Pose& pose) {
  const Vec3 ahead = rotate(pose.rotation, {1, 0, 0}), port = rotate(pose.rotation, {0, 1, 0});
  const Vec3 up = rotate(pose.rotation, {0, 0, 1});
  const Vec3& at = pose.position_m;
  return {ahead.x, port.x, up.x, at.x, ahead.y, port.y, up.y, at.y,
          ahead.z, port.z, up.z, at.z, 0,       0,      0,    1};
}

Status equal_beams(const StoredSequence& sequence) {
  if (sequence.manifest.info.sonar.azimuth_rad.empty()) return {};
  return refused_sequence(sequence,
                          "its beams are not equally spaced, but this format computes azimuths "
                          "from a field of view. Use --format hdf5 or mcap");
}

}  // namespace ensonify
