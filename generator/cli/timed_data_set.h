// Makes data sets as `generate` does, measures them and removes them.
//
//   TimedCase                   a scenario, the number of its pings, and what else is measured
//   DataSetPlan  plan_data_set  with as many sequences as the pings need
//   TimedGroup  time_group      the rows of one table
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/report.h"
#include "core/error.h"
#include "run/options.h"
#include "run/sequence_worlds.h"

namespace ensonify {

struct TimedCase {
  std::string name;
  ScenarioOptions input;
  int threads = 0;           // 0: all cores
  std::uint32_t pings = 24;  // the least number of them
  // Overrides for the ping whose time series is compared with the reference backend, which needs
  // seconds for 50,000 scatterers of a ping: some cases have fewer rays there. Absent: not
  // compared.
  std::optional<std::vector<Override>> compared = {};
};

struct TimedGroup {
  std::string name, title;
  double BenchSizes::*grows = nullptr;  // as in BenchTable
  std::vector<TimedCase> cases;
};

struct DataSetPlan {
  ScenarioOptions input;           // `sequences` is among its overrides
  std::optional<PingRange> pings;  // of each sequence; absent: all
  // Whether the time per ping includes worlds. It does if several sequences have a world each, but
  // not with a single world, because a longer data set has only one as well.
  bool times_worlds = false;
};

// At least `pings` pings: a part of one sequence, or as many whole sequences as needed, whatever
// number the scenario states. Errors (usage): those of load_scenario and prepare_without_world.
Result<DataSetPlan> plan_data_set(const ScenarioOptions& input, std::uint32_t pings);

// Makes a data set of each case in `folder`, then all of them again, `runs` times. The time of a
// data set starts at the scenario if the plan includes worlds, and otherwise with existing worlds
// and tables. Errors: usage (a scenario is wrong), io, interrupted.
Result<BenchTable> time_group(const TimedGroup& group, const std::filesystem::path& folder,
                              int runs,
                              const std::function<void(const std::string&)>& on_progress = {});

}  // namespace ensonify
