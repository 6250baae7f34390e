// How fast whole data sets are made, from the scene to the disk: one by kind of file, the shipped
// scenes with the files that they ask for.
//
//   DataSetCase  data_set_cases   the scenarios, embedded by the build
//   BenchMesh    bench_meshes     the meshes that they read, embedded likewise
//   write_case                    ... as files
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
// app/CMakeLists.txt. The first one, `full`, is made by kind of file; the others are scenes.
std::span<const DataSetCase> data_set_cases();

struct BenchMesh {
  const char* name;  // of meshes/NAME.obj, where the scenes look for it
  const char* text;
};

std::span<const BenchMesh> bench_meshes();

// The scenario's file in `folder`, next to the meshes. Error (io).
Result<std::filesystem::path> write_case(const DataSetCase& which,
                                         const std::filesystem::path& folder);

struct FileKind {
  const char* name;
  const char* output;  // YAML, in place of the scenario's section `output`; null: as it stands
};

// The time series alone, then with one kind of file more, then the defaults, and every file that
// belongs to a ping.
std::span<const FileKind> file_kinds();
// The files that a scenario asks for, and nothing else.
std::span<const FileKind> own_files();

struct DataSetBenchOptions {
  int threads = 0;  // 0: as many as the machine has
  // Of each data set, at least: of one sequence, or of as many as they take.
  std::uint32_t pings = 24;
  int runs = 3;                  // of each kind
  std::filesystem::path folder;  // where data sets are made and removed again
  std::function<void(const std::string&)> on_progress = {};
};

// Makes a data set of each kind, then all of them again, so that what else the machine does meets
// every kind alike. Errors: usage (the scenario is wrong), io, interrupted.
Result<DataSetReport> bench_data_set(const DataSetCase& which, std::span<const FileKind> kinds,
                                     const DataSetBenchOptions& options);

// The same of a scenario's file with the files that it asks for itself, named after its file.
Result<DataSetReport> bench_scenario(const ScenarioOptions& input,
                                     const DataSetBenchOptions& options);

}  // namespace ensonify
