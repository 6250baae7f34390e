// The ROS topics of a sequence's navigation sensors, from its tables. Private to export/.
//
//   body_in_world   from the pose of the sonar
//   sensor_frames   static transforms on the body
//   SensorTopics    start  write_before
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/navigation_tables.h"
#include "export/job.h"
#include "export/mcap_topics.h"

namespace ensonify {

inline constexpr char kBodyFrame[] = "base_link";

Pose body_in_world(const NavigationInfo& navigation, const Pose& sonar_in_world);

// The sonar and each sensor on the body, with frames as the messages want them: that of the DVL has
// z along its axis and x forward, that of the altimeter x along the beam.
std::vector<TfMessage::Transform> sensor_frames(const NavigationInfo& navigation,
                                                const RosHeader& body, const char* sonar_frame);

class SensorTopics {
 public:
  // Opens the tables; there are none without sensors. All must outlive it. Error (io).
  Status start(const ExportJob& job, const StoredSequence& sequence);

  // Writes the rows of all tables with times below `own_ns` of the sequence, in the order of time,
  // each later by `shift_ns`. Returns the time of the last message; `last_ns` without one. Error
  // (io): a table has an invalid row, or times that fall.
  Result<std::uint64_t> write_before(std::uint64_t own_ns, std::uint64_t shift_ns,
                                     std::uint64_t last_ns, McapChannels& channels);

 private:
  struct Table {
    NavigationTable kind = NavigationTable::imu;
    std::filesystem::path path;
    std::ifstream file;
    std::vector<double> row;  // the next one; empty at the end
    std::uint64_t time_ns = 0;
  };
  Status advance(Table& table);
  void write(const Table& table, std::uint64_t time_ns, McapChannels& channels);

  const StoredSequence* sequence_ = nullptr;
  std::vector<Table> tables_;
};

}  // namespace ensonify
