// The speed of making whole data sets, from scene to disk. One data set is measured by kind of
// file, and the shipped scenes with the files that they select.
//
//   DataSetCase  data_set_cases   the scenarios, embedded by the build
//   BenchMesh    bench_meshes     the meshes that they read, also embedded
//   write_case                    writes a case to files
//   FileKind     file_kinds       the value of `output` in each row
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

// Defined in a source file that scripts/cmake/EmbedFiles.cmake writes from the list in
// app/CMakeLists.txt. The first one, `full`, is measured by kind of file; the others are scenes.
std::span<const DataSetCase> data_set_cases();

struct BenchMesh {
  const char* name;  // the scenes look for meshes/NAME.obj
  const char* text;
};

std::span<const BenchMesh> bench_meshes();

// Writes the scenario's file to `folder`, next to the meshes. Error (io).
Result<std::filesystem::path> write_case(const DataSetCase& which,
                                         const std::filesystem::path& folder);

struct FileKind {
  const char* name;
  const char* output;  // YAML, replaces the scenario's section `output`; null: unchanged
};

// The time series alone, then with one additional kind of file each, then the defaults, and all
// files of a ping.
std::span<const FileKind> file_kinds();
// Only the files that a scenario selects.
std::span<const FileKind> own_files();

struct DataSetBenchOptions {
  int threads = 0;  // 0: all cores
  // Minimum number of pings of each data set, from one sequence or as many as needed.
  std::uint32_t pings = 24;
  int runs = 3;                  // of each kind
  std::filesystem::path folder;  // where data sets are made and removed
  std::function<void(const std::string&)> on_progress = {};
};

// Makes a data set of each kind, then all of them again, so that other load on the machine affects
// every kind equally. Errors: usage (the scenario is wrong), io, interrupted.
Result<DataSetReport> bench_data_set(const DataSetCase& which, std::span<const FileKind> kinds,
                                     const DataSetBenchOptions& options);

// The same for a scenario file with the files that it selects, named after the file.
Result<DataSetReport> bench_scenario(const ScenarioOptions& input,
                                     const DataSetBenchOptions& options);

}  // namespace ensonify
