// Expands a sweep file into its runs: the checked scenario of each, with its id and cost. Writes
// nothing.
//
//   Cost  CostOf
//   SweepRun  Sweep  expand_sweep
//   plan_of                        its lines in plan.jsonl
//   scenario_of  first_scenario_of  with_place   the scenario of a run, built again; its later
//   errors
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "scenario/scenario.h"
#include "sweep/folder.h"
#include "sweep/sweep_file.h"

namespace ensonify {

// Of a data set.
struct Cost {
  std::uint64_t pings = 0;       // of all sequences
  std::uint64_t files = 0;       // exact
  std::uint64_t disk_bytes = 0;  // compressed parts and tables estimated from typical images
  double core_s = 0;             // seconds of one core; used to balance shards
};

// Estimated from the scenario alone, in far less than a millisecond, with the same result on every
// machine. Called from several threads at once. Errors begin with the key path that causes them.
using CostOf = std::function<Result<Cost>(Scenario)>;

struct SweepRun {
  std::string id;  // first 16 hexadecimal digits of the SHA-256 of the resolved scenario, its
                   // input files named by their own hashes
  std::string name;
  Point point;
  std::uint64_t seed = 0;
  Cost cost;
};

struct Sweep {
  SweepFile file;
  std::vector<SweepRun> runs;  // in order, no id twice
  std::size_t left_out = 0;    // points that skip_if skipped
  std::size_t repeated = 0;    // points with the scenario of an earlier one
};

// Passes every run through the parser of scenarios. Errors (usage): all errors of all runs, each
// once, with its place and the runs that have it; io: an input file cannot be read.
Result<Sweep> expand_sweep(SweepFile file, const CostOf& cost_of, const Workers& workers);

// Line i is run i.
Plan plan_of(const Sweep& sweep);

// The scenario as sampled for one of its sequences. Errors: those of expand_sweep for this run.
Result<Scenario> scenario_of(const SweepFile& file, const Point& point, SequenceDraw draw = {},
                             ErrorPlaces places = ErrorPlaces::shown);

// ... for its first sequence that can be read.
Result<Scenario> first_scenario_of(const SweepFile& file, const Point& point);

// Adds the place of the key, in the sweep file or the base, to each line `key.path: ...` of an
// error that is found only when a world is built.
Error with_place(const Error& error, const SweepFile& file, const Point& point);

}  // namespace ensonify
