// Measures the speed of this machine by stage, each next to its plain reference, in one run. Whole
// data sets and their growth are measured by app/bench_data_sets and app/bench_growth, and reported
// with them.
//
//   BenchCase  bench_cases   timed cases: fixed sonars over one fixed world without files
//   make_bench_world         sea floor of 103,000 triangles with boxes, cylinders and spheres on it
//   bench_pose               pose of the sonar
//   BenchOptions  BenchReport  run_bench
//   DataSetReport  GrowthReport  fitted_exponent
//   bench_text               the table that people read
//   bench_json               the same numbers for programs
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/sonar.h"
#include "world/world.h"

namespace ensonify {

struct BenchCase {
  std::string name;
  Sonar sonar;
  Water water;
};

//   full     512 beams x 114 rays, 60 m, b = 29.9 kHz, 90 deg: Choi et al. 2021 as released
//   table1   the same with b = 2.95 kHz: Table 1 as printed
//   reduced  512 beams x 11 rays, 10 m
//   dense    512 beams x (912 x 8) rays, 60 m
//   array    full, received by 256 elements at half a wavelength and focused at every sample
std::vector<BenchCase> bench_cases();

// Scaled to the range, so that in every case hits fill the record.
World make_bench_world(double range_max_m);

// Nose down by half a fan of 20 deg: the highest rays are level.
Pose bench_pose();

struct BenchOptions {
  std::vector<BenchCase> cases = bench_cases();
  int threads = 0;             // 0: as many as the machine has
  double seconds = 0.3;        // repetition time of each measurement; at least three runs
  std::filesystem::path disk;  // where files are written; empty: the system's temporary folder
  bool gentle_peaks = false;   // machine peaks from small work: for tests
  std::function<void(const std::string&)> on_progress;
};

// The median time of one thing, on one thread unless its name says otherwise.
struct Timing {
  std::string name;
  double ms = 0;
  double part = 1;   // timed part of the work; `ms` is scaled to the whole
  double share = 0;  // of the machine's peak in the same run; 0: not meaningful
  std::string share_of = {};
};

struct CaseReport {
  std::string name;
  int beams = 0, rays_per_beam = 0, samples = 0, transform = 0;
  std::size_t scatterers = 0;
  // From trace to series in memory, a ping on each thread; on one thread; with expected power.
  double pings_per_s = 0, pings_per_s_1_thread = 0, clean_pings_per_s = 0;
  // The plain methods' on all threads: their sums of stages, with our trace, scatterers and draws.
  double direct_pings_per_s = 0, recurrence_pings_per_s = 0;
  double error = 0, worst_tenth_error = 0;        // of the backend's series against the exact one
  double direct_error = 0, recurrence_error = 0;  // of the plain methods' spectra
  std::vector<Timing> stages, references;
};

struct MachineReport {
  int threads = 0;
  std::string simd;
  double fma_gflops = 0;  // of one core, single precision, a multiply-add counted as two
  double copy_gb_s = 0;   // of one core, bytes read and bytes written both counted
  double disk_mb_s = 0;   // past the page cache, in one stream
  bool disk_is_memory = false;
  bool disk_is_direct =
      true;  // false: the file system has no O_DIRECT, so written and synchronized
};

// A data set with one choice of files, from the scene to the disk.
struct FileKindReport {
  std::string name;
  double pings_per_s = 0, least_pings_per_s = 0, most_pings_per_s = 0;  // median and range of runs
  double core_ms_per_ping = 0;  // of all threads and the system, summed; median
  double mb_per_ping = 0;       // of all files of the data set
  // Where core_ms_per_ping goes (core/stage_times.h); `rest` is what no stage counts: the start of
  // sequences, threads that help with a stage, and finishing.
  std::vector<Timing> stages;
  double physics_share = 0;  // of core_ms_per_ping
};

struct DataSetReport {
  std::string name;
  int beams = 0, samples = 0;
  int pings = 0, runs = 0;  // of each kind
  std::vector<FileKindReport> kinds;
};

struct GrowthPoint {
  double value = 0;  // of what grows
  int pings = 0;     // of each run
  double pings_per_s = 0, core_ms_per_ping = 0;
  double world_core_ms = 0;  // to read the scenario and build its world, once
};

// Whole data sets that differ in one size.
struct GrowthReport {
  std::string name;  // of that size
  int runs = 0;      // of each point; figures are their medians
  std::vector<GrowthPoint> points;
};

// The least-squares slope of log y over log x: k where y grows as x^k. Nothing with fewer than two
// different x. All must be positive.
std::optional<double> fitted_exponent(const std::vector<double>& x, const std::vector<double>& y);

struct BenchReport {
  MachineReport machine;
  std::vector<CaseReport> cases;
  std::vector<DataSetReport> data_sets;
  std::vector<GrowthReport> growth;
};

// Without data sets and growth. Errors (io): the folder of `disk` cannot be written.
Result<BenchReport> run_bench(const BenchOptions& options);

std::string bench_text(const BenchReport& report);
std::string bench_json(const BenchReport& report);

}  // namespace ensonify
