// SEQUENCE.mcap: the polar image of each ping as marine_acoustic_msgs/ProjectedSonarImage on
// /sonar/image, and the sonar's pose as geometry_msgs/PoseStamped on /sonar/pose. One file per
// sequence, because the times of sequences overlap.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "dataset/layout.h"
#include "export/job.h"
#include "export/mcap_file.h"
#include "export/ros_messages.h"
#include "formats/bytes.h"
#include "formats/npy.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr char kWorldFrame[] = "world";
constexpr char kFanFrame[] = "sonar_fan";

// builtin_interfaces/Time has 31 bits for seconds.
constexpr double kMostSeconds = 2147483647;

Result<std::vector<double>> axis(const ExportJob& job, const StoredSequence& sequence,
                                 const char* name, std::uint64_t count) {
  const auto path = stored_file(job.dataset, sequence.row.sequence, name);
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyFloat64, {count});
  if (!array) return array.error();
  return values_in<double>(array->data());
}

// What all images of a sequence have in common.
Result<ProjectedSonarImage> image_of(const ExportJob& job, const StoredSequence& sequence) {
  const auto azimuths = axis(job, sequence, "azimuth_rad.npy", sequence.beams);
  if (!azimuths) return azimuths.error();
  const auto ranges = axis(job, sequence, "range_m.npy", sequence.samples);
  if (!ranges) return ranges.error();
  ProjectedSonarImage image;
  image.header.frame_id = kFanFrame;
  image.frequency_hz = static_cast<float>(sequence.frequency_hz);
  image.sound_speed_m_s = static_cast<float>(sequence.sound_speed_m_s);
  image.rx_beamwidths_rad.assign(sequence.beams, static_cast<float>(sequence.beam_width_rad));
  image.tx_beamwidths_rad.assign(sequence.beams, static_cast<float>(sequence.elevation_width_rad));
  for (const double azimuth : *azimuths) {
    image.beam_directions.push_back({0, -std::sin(azimuth), std::cos(azimuth)});
  }
  image.ranges_m.assign(ranges->begin(), ranges->end());
  image.beam_count = static_cast<std::uint32_t>(sequence.beams);
  return image;
}

Result<std::uint64_t> nanoseconds(const StoredSequence& sequence, const StoredPing& ping) {
  if (ping.time_s >= 0 && ping.time_s < kMostSeconds) {
    return static_cast<std::uint64_t>(std::llround(ping.time_s * 1e9));
  }
  return Error{ErrorKind::usage,
               fmt::format("sequence {}, ping {}: its time is {} s; MCAP and ROS need 0 to "
                           "2147483647 s: shift the trajectory's times, or use another format",
                           sequence.row.sequence, ping.ping, ping.time_s)};
}

Status write_sequence(const ExportJob& job, const fs::path& path, const StoredSequence& sequence) {
  auto image = image_of(job, sequence);
  if (!image) return image.error();
  McapFile file(path, "ros2", "ensonify");
  // rosbag2 looks for this key.
  const std::map<std::string, std::string> metadata = {{"offered_qos_profiles", ""}};
  const std::uint16_t poses =
      file.add_channel(file.add_schema(PoseStamped::kName, "ros2msg", PoseStamped::kDefinition),
                       "/sonar/pose", "cdr", metadata);
  const std::uint16_t images = file.add_channel(
      file.add_schema(ProjectedSonarImage::kName, "ros2msg", ProjectedSonarImage::kDefinition),
      "/sonar/image", "cdr", metadata);
  std::uint32_t counter = 0;
  std::uint64_t last_ns = 0;
  const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto time_ns = nanoseconds(sequence, ping);
    if (!time_ns) return time_ns.error();
    if (*time_ns < std::exchange(last_ns, *time_ns)) {
      return damaged(
          job.dataset.dir / layout::in_sequence(sequence.row.sequence, "poses.csv"),
          fmt::format("the time of ping {} is earlier than that of the ping before it", ping.ping));
    }
    const auto grey = path_of(job, sequence, ping, grey_row(ImageView::polar));
    if (!grey) return grey.error();
    auto pixels = grey_pixels(job, *grey, sequence.samples, sequence.beams);
    if (!pixels) return pixels.error();
    image->header.time_ns = *time_ns;
    image->data = std::move(*pixels);
    file.write(poses, counter, *time_ns,
               encode(PoseStamped{{*time_ns, kWorldFrame}, ping.sonar_in_world}));
    file.write(images, counter++, *time_ns, encode(*image));
    return {};
  });
  const Status closed = file.close();
  return read ? closed : read;
}

}  // namespace

Status write_mcap(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_row(ImageView::polar)); !there) return there;
    return write_sequence(job, target / fmt::format("{:06}.mcap", sequence.row.sequence), sequence);
  });
}

}  // namespace ensonify
