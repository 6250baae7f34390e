// Makes one data set as `generate` does, measures it and removes it.
//
//   DataSetPlan  plan_data_set   a scenario with as many sequences as a number of pings needs
//   BenchSite                    where and by which numerics data sets are made
//   TimedDataSet  time_data_set  time_in_world
//   core_ms                      processor time up to now
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "app/commands.h"
#include "app/sequence_worlds.h"
#include "app/tables.h"
#include "core/error.h"
#include "core/stage_times.h"

namespace ensonify {

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

struct BenchSite {
  int threads = 0;               // 0: all cores
  std::filesystem::path folder;  // where data sets are made and removed
  Numerics numerics;             // settled
};

struct TimedDataSet {
  int beams = 0, samples = 0, pings = 0;
  double pings_per_s = 0, core_ms_per_ping = 0, mb_per_ping = 0;
  std::array<double, kStageCount> stages_ms{};  // per ping
};

// The time starts at the scenario if the plan includes worlds, and otherwise with existing worlds
// and tables. Errors: usage (the scenario is wrong), io, interrupted.
Result<TimedDataSet> time_data_set(const DataSetPlan& plan, const BenchSite& site);

// In existing worlds of plan.input. The tables are made before the clock starts.
Result<TimedDataSet> time_in_world(const SequenceWorlds& worlds, const DataSetPlan& plan,
                                   const BenchSite& site);

// Includes all threads, importer processes that have ended, and the system's work for both.
double core_ms();

}  // namespace ensonify
