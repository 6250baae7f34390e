// The ROS topics of a sequence's navigation sensors, from its tables. Private to export/.
//
//   SensorTopics   start  write_before
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "core/navigation_tables.h"
#include "export/job.h"
#include "export/mcap_topics.h"

namespace ensonify {

class SensorTopics {
 public:
  // Opens the tables; there are none without sensors. The sequence must outlive it. Error (io).
  Status start(const StoredDataset& dataset, const StoredSequence& sequence);
  // The time of the earliest row; none without rows.
  std::optional<std::uint64_t> first_ns() const;

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
