// How fast whole data sets are made, from the scene to the disk, for each kind of file.
//
//   DataSetCase  data_set_cases   the scenarios, embedded by the build
//   FileKind     file_kinds       what `output` asks for in each row
//   DataSetBenchOptions  bench_data_set  bench_scenario
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "app/commands.h"
#include "bench/bench.h"
#include "core/error.h"

namespace ensonify {

struct DataSetCase {
  const char* name;
  const char* text;  // of the scenario
};

// Defined in a source that scripts/cmake/EmbedFiles.cmake writes from the list in
// app/CMakeLists.txt.
std::span<const DataSetCase> data_set_cases();

struct FileKind {
  const char* name;
  const char* output;  // YAML, in place of the scenario's section `output`
};

// The time series alone, then with one kind of file more, then the defaults, and every file that
// belongs to a ping.
std::span<const FileKind> file_kinds();

struct DataSetBenchOptions {
  int threads = 0;  // 0: as many as the machine has
  // Of each data set, as far as the scenario has so many: of the first sequence, then of the next.
  std::uint32_t pings = 24;
  int runs = 3;                  // of each kind
  std::filesystem::path folder;  // where data sets are made and removed again
  std::function<void(const std::string&)> on_progress = {};
};

// Makes a data set of each kind, then all of them again, so that what else the machine does meets
// every kind alike. Errors: usage (the scenario is wrong), io, interrupted.
Result<DataSetReport> bench_data_set(const DataSetCase& which, const DataSetBenchOptions& options);

// The same of a scenario with the files that it asks for itself, named after its file.
Result<DataSetReport> bench_scenario(const ScenarioOptions& input,
                                     const DataSetBenchOptions& options);

}  // namespace ensonify
