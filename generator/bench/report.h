// What `ensonify bench` reports: tables of whole data sets, each measured several times, and the
// machine that made them. cli/bench_cases.h lists what is measured, cli/timed_data_set.h measures.
//
//   BenchSizes  BenchRow  BenchTable  BenchReport
//   SeriesError  series_error   how far a time series is from the reference
//   fitted_exponent
//   bench_text                  the tables that people read
//   bench_json                  the same numbers for programs
#pragma once

#include <complex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/machine.h"

namespace ensonify {

// What the time of a data set may grow with.
struct BenchSizes {
  double threads = 0, beams = 0, samples = 0;
  double rays = 0;  // of a ping
  double objects = 0;
  double triangles = 0;  // of all meshes
};

struct SeriesError {
  double relative = 0;     // L2 over the record
  double worst_tenth = 0;  // the largest over a tenth of the record against its own norm; tenths
                           // under 1e-6 of the record's norm are left out
};

// Both are [beams x samples].
SeriesError series_error(std::span<const std::complex<float>> series,
                         std::span<const std::complex<float>> exact, int beams);

struct StageMs {
  std::string name;
  double ms = 0;
};

// A data set, from the scene to the disk. Numbers are medians of its runs where nothing else is
// said.
struct BenchRow {
  std::string name;
  BenchSizes sizes;
  int pings = 0;  // of each run
  double pings_per_s = 0, least_pings_per_s = 0, most_pings_per_s = 0;
  double core_ms_per_ping = 0;  // of all threads and the system, summed
  double mb_per_ping = 0;       // of all files of the data set
  double world_core_ms = 0;     // to read the scenario and build its first world
  // Where core_ms_per_ping goes (core/stage_times.h); `rest` is what no stage counts: the start of
  // sequences, threads that help with a stage, and finishing.
  std::vector<StageMs> stages = {};
  double physics_share = 0;               // of core_ms_per_ping
  std::optional<SeriesError> error = {};  // of ping 0; absent: not measured
};

// Data sets that were measured in turns, so that other load on the machine affects all of them.
struct BenchTable {
  std::string name, title;
  double BenchSizes::*grows = nullptr;  // the only size that differs between the rows; null: none
  int runs = 0;                         // of each row
  std::vector<BenchRow> rows = {};
};

struct BenchReport {
  MachineReport machine;
  std::vector<BenchTable> tables;
};

// The least-squares slope of log y over log x: k where y grows as x^k. Nothing with fewer than two
// different x. All must be positive.
std::optional<double> fitted_exponent(const std::vector<double>& x, const std::vector<double>& y);

std::string bench_text(const BenchReport& report);
std::string bench_json(const BenchReport& report);

}  // namespace ensonify
