// The growth of the time of whole data sets with threads and with the sizes of a scenario.
//
//   GrowthStep  GrowthAxis  growth_axes   the quantity that grows, and its values
//   GrowthBenchOptions  bench_growth      one data set for each value, several times
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/bench_data_sets.h"
#include "app/session.h"
#include "bench/bench.h"
#include "core/error.h"

namespace ensonify {

struct GrowthStep {
  int threads = 1;
  std::uint32_t pings = 8;
  std::vector<Override> overrides;
};

struct GrowthAxis {
  std::string name;
  double (*size)(const Session&);  // null: the threads of the step
  std::vector<GrowthStep> steps;
};

//   threads    1, 2, 4 ... up to `threads`
//   beams      128 to 1024
//   samples    of the record, by bandwidth
//   rays       of a ping, by rays in elevation
//   objects    with up to 4096 spheres over the seabed
//   triangles  of the seabed, 39,000 to 2.5 million
// All other keys are those of configs/bench/full.yaml with 128 beams. The files are the default
// ones without Cartesian and 8-bit images.
std::vector<GrowthAxis> growth_axes(int threads);

struct GrowthBenchOptions {
  int runs = 3;                  // of each step
  std::filesystem::path folder;  // where data sets are made and removed
  std::function<void(const std::string&)> on_progress = {};
};

// Makes each step once, then all of them again, in worlds that are built once. Errors: usage (the
// scenario of a step is invalid), io, interrupted.
Result<GrowthReport> bench_growth(const DataSetCase& base, const GrowthAxis& axis,
                                  const GrowthBenchOptions& options);

}  // namespace ensonify
