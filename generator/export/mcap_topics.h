// The ROS topics of a sequence's pings, for those of its files that exist. Private to export/.
//
//   McapChannels   a file's topics, each made when its first message is written
//   SonarTopics    start  write
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "dataset/read_pictures.h"
#include "export/job.h"
#include "export/mcap_file.h"
#include "export/ros_messages.h"

namespace ensonify {

class McapChannels {
 public:
  explicit McapChannels(McapFile& file) : file_(file) {}

  // Times must not decrease. `latched`: late subscribers get the last message too.
  template <class Message>
  void write(const std::string& topic, std::uint64_t time_ns, const Message& message,
             bool latched = false) {
    write_bytes(topic, Message::kName, time_ns, encode(message), latched);
  }

 private:
  struct Channel {
    std::uint16_t number = 0;
    std::uint32_t messages = 0;
  };
  void write_bytes(const std::string& topic, const std::string& type, std::uint64_t time_ns,
                   const std::string& bytes, bool latched);

  McapFile& file_;
  std::map<std::string, std::uint16_t> schemas_;  // by type
  std::map<std::string, Channel> channels_;       // by topic
};

class SonarTopics {
 public:
  // Both must outlive it.
  SonarTopics(const ExportJob& job, const StoredSequence& sequence)
      : job_(job), sequence_(sequence) {}

  // Reads what all pings have in common. Errors: (usage) there is no polar image; (io).
  Status start();
  // All messages of a ping. Error (io): a file of it is missing or damaged.
  Status write(const StoredPing& ping, std::uint64_t time_ns, McapChannels& channels);

 private:
  bool has_grey(ImageView view) const;
  void make_image(const std::vector<double>& azimuths, const std::vector<double>& ranges);
  void make_infos();
  void write_frames(const StoredPing& ping, std::uint64_t time_ns, McapChannels& channels);
  Status write_polar(const StoredPing& ping, std::uint64_t time_ns, McapChannels& channels);
  Status write_cartesian(const StoredPing& ping, std::uint64_t time_ns, McapChannels& channels);
  void write_masks(const StoredPixels& pixels, const std::string& prefix, std::uint64_t time_ns,
                   McapChannels& channels) const;
  Status write_detections(const StoredPing& ping, ImageView view, const std::string& prefix,
                          std::uint64_t time_ns, McapChannels& channels) const;
  Status write_points(const StoredPing& ping, const StoredPixels& polar, std::uint64_t time_ns,
                      McapChannels& channels) const;
  void add_surfaces(const StoredPixels& polar, PointCloud2& cloud) const;
  Status add_scatterers(const StoredPing& ping, PointCloud2& cloud) const;

  const ExportJob& job_;
  const StoredSequence& sequence_;
  std::vector<double> azimuths_rad_;
  ProjectedSonarImage image_;
  SonarInfo levels_info_, grey_info_;
  std::optional<std::uint64_t> told_ns_;  // when the infos were written last
};

}  // namespace ensonify
