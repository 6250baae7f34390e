// One data set, made as `generate` makes it and removed again, and what it took.
//
//   DataSetPlan  plan_data_set   a scenario with the sequences that a number of pings takes
//   BenchSite                    where and with what data sets are made
//   TimedDataSet  time_data_set  time_in_world
//   core_ms                      processor time so far
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
  // Several sequences with a world each: then worlds are part of what a ping takes. One world is
  // not, since a longer data set has no more of it.
  bool times_worlds = false;
};

// At least `pings` pings: a part of one sequence, or as many whole sequences as they take, whatever
// number the scenario gives. Errors (usage): those of load_scenario and prepare_without_world.
Result<DataSetPlan> plan_data_set(const ScenarioOptions& input, std::uint32_t pings);

struct BenchSite {
  int threads = 0;               // 0: as many as the machine has
  std::filesystem::path folder;  // where data sets are made and removed
  Numerics numerics;             // settled
};

struct TimedDataSet {
  int beams = 0, samples = 0, pings = 0;
  double pings_per_s = 0, core_ms_per_ping = 0, mb_per_ping = 0;
  std::array<double, kStageCount> stages_ms{};  // of a ping
};

// From the scenario where the plan times worlds, else from the worlds of sequences and the tables
// on. Errors: usage (the scenario is wrong), io, interrupted.
Result<TimedDataSet> time_data_set(const DataSetPlan& plan, const BenchSite& site);

// In worlds that are there: those of plan.input. The tables are made before the clock starts.
Result<TimedDataSet> time_in_world(const SequenceWorlds& worlds, const DataSetPlan& plan,
                                   const BenchSite& site);

// Of all threads, of importers that have ended, and of the system for them.
double core_ms();

}  // namespace ensonify
