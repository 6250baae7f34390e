// What follows from the sonar, the water and the record alone, and takes as long as some pings of a
// small run to work out: runs that have it in common share it.
//
//   PipelineTables  pipeline_tables
//   TableCache      those that are in use, and the last ones
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "app/hidden_power.h"
#include "app/numerics.h"
#include "app/session.h"
#include "synthesis/backend.h"
#include "trace/fan.h"

namespace ensonify {

struct PipelineTables {
  Fan fan;
  std::unique_ptr<Backend> backend;  // may be used by several threads at once
  std::vector<std::int32_t> cartesian_map;
  HiddenPower hidden_power;
};

// From `numerics.tables`, where it has any, if they are there. Throws DeviceFailure.
std::shared_ptr<const PipelineTables> pipeline_tables(const Session& session,
                                                      const Numerics& numerics);

// Equal keys: equal tables, on one machine and as long as input files do not change.
std::string table_key(const Scenario& scenario);

class TableCache {
 public:
  // From several threads at once; whoever is first makes them.
  template <class Make>
  std::shared_ptr<const PipelineTables> of(const std::string& key, Make make) {
    const std::shared_ptr<Entry> entry = entry_of(key);
    const std::lock_guard lock(entry->mutex);
    if (!entry->tables) entry->tables = make();
    // Who holds the tables holds their entry.
    return {entry, entry->tables.get()};
  }

 private:
  struct Entry {
    std::mutex mutex;
    std::shared_ptr<const PipelineTables> tables;
  };
  static constexpr std::size_t kKept = 2;

  std::shared_ptr<Entry> entry_of(const std::string& key);

  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Entry>> entries_;
  std::deque<std::shared_ptr<Entry>> last_;  // in the order of their use
};

}  // namespace ensonify
