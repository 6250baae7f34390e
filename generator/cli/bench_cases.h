// What `ensonify bench` measures without a scenario of the user.
//
//   EmbeddedScenario  bench_scenarios   the scenarios, embedded by the build
//   EmbeddedMesh      bench_meshes      the meshes that they read, also embedded
//   write_bench_files
//   bench_groups                        the rows of each table
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "cli/timed_data_set.h"
#include "core/error.h"

namespace ensonify {

struct EmbeddedScenario {
  const char* name;  // of the file NAME.yaml
  const char* text;
};

struct EmbeddedMesh {
  const char* name;  // the scenes look for meshes/NAME.obj
  const char* text;
};

// Defined in source files that scripts/cmake/EmbedFiles.cmake writes from the lists in
// app/CMakeLists.txt.
std::span<const EmbeddedScenario> bench_scenarios();
std::span<const EmbeddedMesh> bench_meshes();

// Writes all of them to `folder`. Error (io).
Status write_bench_files(const std::filesystem::path& folder);

// With the scenarios in `folder`. `pings` is the least number of pings of a data set, `threads` is
// not 0.
//   series     the time series of `full`, as the paper's tables and with more work in each ping;
//              compared with the reference
//   files      `full` with the time series alone, with one more kind of file each, with the
//              defaults, and with all files of a ping
//   scenes     the other scenarios, with the files that they ask for
//   features   a shipped sonar over a flat floor, plain and with one more feature each
//   ensemble   realizations of one scene: their moments alone, and with their series
//   threads    1, 2, 4 ... up to all of them
//   beams, samples (by bandwidth), rays (in elevation), objects (spheres over the seabed),
//   triangles (of the seabed)
// What grows, grows from `full` with 128 beams and its default files except Cartesian and 8-bit
// images, in data sets of 8 pings or 4 a thread.
std::vector<TimedGroup> bench_groups(const std::filesystem::path& folder, int threads,
                                     std::uint32_t pings);

}  // namespace ensonify
