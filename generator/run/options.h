// What the user asks of a run.
//
//   ScenarioOptions  RunHooks  MakeOptions
//   GenerateOptions  SweepOptions
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/runtime.h"
#include "ping/tables.h"
#include "scenario/scenario.h"
#include "sweep/shards.h"

namespace ensonify {

struct ScenarioOptions {
  std::filesystem::path scenario;
  std::vector<Override> overrides;  // from --set, --seed and similar options
  // Text that replaces the content of the file. Messages still use the file's name, and relative
  // paths its folder.
  std::optional<std::string> text = {};
};

// Callbacks for programs that call `generate` themselves: they report progress and stop it. With
// them, the program does not handle signals and prints nothing on stderr.
struct RunHooks {
  std::function<void(std::string_view)> warn;
  std::function<void(std::uint64_t done, std::uint64_t all)> progress;  // in pings; from any thread
  const std::atomic<bool>* stopped = nullptr;                           // true: as an interrupt
};

// The common options of `generate` and `sweep`.
struct MakeOptions {
  std::filesystem::path output;  // empty: not given, which a sweep's --list allows
  // The part of the sequences (finalize_dataset finishes the data set) or of the runs. Absent: all,
  // or for a sweep the part of the Slurm array task.
  std::optional<Shard> shard;
  int threads = 0;
  BackendChoice backend = BackendChoice::automatic;
  SimdLevel simd = best_simd_level();
  bool overwrite = false;
  bool partial = false;  // --finalize without missing ones
  bool quiet = false;
  bool ignore_free_space = false;  // starts even if the disk has too little room
};

struct GenerateOptions : MakeOptions {
  ScenarioOptions input;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> pings;      // [first, last)
  std::optional<std::pair<std::uint32_t, std::uint32_t>> sequences;  // [first, last)
  const RunHooks* hooks = nullptr;                                   // goes with `quiet`
};

struct SweepOptions : MakeOptions {
  std::filesystem::path sweep;
  std::vector<Override> overrides;  // --set, of the base
};

}  // namespace ensonify
