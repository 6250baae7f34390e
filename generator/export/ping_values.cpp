#include "export/ping_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "dataset/layout.h"
#include "dataset/read_pictures.h"
#include "formats/bytes.h"

namespace ensonify {

Result<LogPing> log_ping_of(const ExportJob& job, const StoredSequence& sequence,
                            std::uint32_t ping, bool counts) {
  LogPing read;
  if (!counts) {
    const CatalogueRow& row = plane_row(ImageView::polar, "level_db");
    if (const Status there = need(job, sequence, row); !there) return there.error();
    auto pixels = read_picture(job.dataset, sequence, ImageView::polar, ping, {"level_db"});
    if (!pixels) return pixels.error();
    read.level_db = std::move(pixels->level_db);
    return read;
  }
  CellReader cells(job.dataset, sequence, ping);
  const bool bytes = sequence.manifest.info.recorder->bits == 8;
  const CatalogueRow& row =
      *find_file(FileScope::ping, bytes ? layout::kRecorded8 : layout::kRecorded16);
  if (const Status there = need(job, sequence, row); !there) return there.error();
  const auto found = cells.read(row);
  if (!found) return found.error();
  if (bytes) {
    for (const std::uint8_t count : values_in<std::uint8_t>(*found)) read.counts.push_back(count);
  } else {
    read.counts = values_in<std::uint16_t>(*found);
  }
  const CatalogueRow& gains = *find_file(FileScope::ping, layout::kRecordedRowGain);
  if (!sequence.has(gains)) return read;
  const auto gain = cells.read(gains);
  if (!gain) return gain.error();
  read.row_gain = values_in<float>(*gain);
  return read;
}

// The inverse of from_roll_pitch_yaw, whose positive pitch is nose down.
LogAttitude attitude_of(const Pose& pose) {
  const Vec3 ahead = rotate(pose.rotation, {1, 0, 0});
  const Vec3 port = rotate(pose.rotation, {0, 1, 0}), up = rotate(pose.rotation, {0, 0, 1});
  double heading = 90 - degrees(std::atan2(ahead.y, ahead.x));
  if (heading < 0) heading += 360;
  return {heading, degrees(std::asin(std::clamp(ahead.z, -1.0, 1.0))),
          degrees(std::atan2(port.z, up.z))};
}

std::int64_t log_time_us(const StoredSequence& sequence, const StoredPing& ping) {
  const auto& recording = sequence.manifest.info.recording;
  return (recording ? recording->start_us : 0) + std::llround(ping.time_s * 1e6);
}

Result<double> full_scale_of(const ExportJob& job, const StoredSequence& sequence) {
  if (job.options.full_scale_db) return *job.options.full_scale_db;
  const auto& png = job.dataset.manifest.png;
  if (png && !png->automatic_gain && same_tvg(*png, Display{})) {
    return png->limits_db[1] - png->gain_db;
  }
  const auto first = log_ping_of(job, sequence, sequence.row.first_ping, false);
  if (!first) return first.error();
  return std::ceil(double{*std::max_element(first->level_db.begin(), first->level_db.end())});
}

Error refused_sequence(const StoredSequence& sequence, const std::string& what) {
  return {ErrorKind::usage, fmt::format("sequence {}: {}", sequence.row.sequence, what)};
}

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
