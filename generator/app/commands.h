// The program's commands. Each returns nothing or the error that the process ends with; messages
// for people go to stderr, what was asked for (`check`, `presets`) to stdout.
//
//   generate finalize_dataset check verify export_command presets bench
//   list_sweep run_sweep sweep_status finalize_sweep
//   report_command preview figure_command render_command
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

#include "app/tables.h"
#include "core/error.h"
#include "core/runtime.h"
#include "export/export.h"
#include "figure/figure.h"
#include "render/render.h"
#include "report/report.h"
#include "scenario/scenario.h"
#include "sweep/shards.h"

namespace ensonify {

struct ScenarioOptions {
  std::filesystem::path scenario;
  std::vector<Override> overrides;  // --set, --seed and the like
  // In place of the file, whose name is still that of messages and whose folder that of paths.
  std::optional<std::string> text = {};
};

// How whoever calls `generate` from a program of their own hears of it and stops it. The process's
// signals are left alone then, and nothing is told on stderr.
struct RunHooks {
  std::function<void(std::string_view)> warn;
  std::function<void(std::uint64_t done, std::uint64_t all)> progress;  // pings; from any thread
  const std::atomic<bool>* stopped = nullptr;                           // true: as an interrupt
};

// What makes data sets: the part that `generate` and `sweep` have in common.
struct MakeOptions {
  std::filesystem::path output;  // empty: none was named, which a sweep's --list allows
  // A part of the sequences (finalize_dataset finishes the data set) or of the runs. Absent: all,
  // or what a Slurm array gives a sweep.
  std::optional<Shard> shard;
  int threads = 0;
  BackendChoice backend = BackendChoice::automatic;
  SimdLevel simd = best_simd_level();
  bool overwrite = false;
  bool partial = false;  // --finalize of what is there
  bool quiet = false;
  bool ignore_free_space = false;  // begins though the disk has no room for all
};

struct GenerateOptions : MakeOptions {
  ScenarioOptions input;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> pings;      // [first, last)
  std::optional<std::pair<std::uint32_t, std::uint32_t>> sequences;  // [first, last)
  const RunHooks* hooks = nullptr;  // goes with `quiet`
};

struct CheckOptions {
  ScenarioOptions input;
  std::filesystem::path output;  // of whose disk the free space is announced; empty: the working
                                 // folder's
  int threads = 0;
  BackendChoice backend = BackendChoice::automatic;
  SimdLevel simd = best_simd_level();
  bool all_worlds = false;  // builds the world of each sequence, not of some alone
};

struct SweepOptions : MakeOptions {
  std::filesystem::path sweep;
  std::vector<Override> overrides;  // --set, of the base
};

struct BenchCommandOptions {
  ScenarioOptions input;       // measures data sets of this scenario alone; none: of the cases
  std::filesystem::path json;  // empty: not written
  std::optional<std::string> case_name;
  std::string only;          // stages, data_sets or growth; empty: all
  std::uint32_t pings = 24;  // of each data set, at least
  int threads = 0;
  double seconds = 0.3;
  std::filesystem::path disk;
};

struct PreviewOptions {
  ScenarioOptions input;
  std::filesystem::path output;  // the page; empty: NAME_preview.html of the working folder
  std::uint32_t pings = 3;       // spread over the run
  std::uint32_t sequence = 0;
  int threads = 0;
  bool full = false;   // with all rays
  bool watch = false;  // again whenever the scenario or a file that it names changes
  bool quiet = false;
};

// Writes the data set, or goes on with it. Error kinds: usage (nothing written), io, interrupted.
Status generate(const GenerateOptions& options);

// Writes the top level of a data set whose sequences shards have made. Error kinds: usage
// (sequences are missing, or the folder holds other work), io.
Status finalize_dataset(const GenerateOptions& options);

// Prints the resolved scenario and, as comments under it, what generating it will cost, for which
// it makes a few pings.
Status check(const CheckOptions& options);

// Error kind damage when anything of the data set is not as its manifest says.
Status verify(const std::filesystem::path& folder, int threads);

// Writes a finished data set in another format. Error kinds: usage (an unknown format comes with
// the nearest one), io, interrupted.
Status export_command(const std::string& format, ExportOptions options, bool quiet);
// Name and description of each format, one a line.
std::string export_format_list();

// Prints the speed of this machine, stage by stage and of whole data sets, and how the latter grow.
// Error kinds: usage, io, interrupted.
Status bench(const BenchCommandOptions& options);
// Of everything that it measures without a scenario.
std::vector<std::string> bench_case_names();

// Prints the plan of a sweep with the cost of each run, and writes nothing. Error kinds: usage
// (also where the plan in the folder has runs that this one has not), io.
Status list_sweep(const SweepOptions& options);

// Makes the runs of the shard that are missing; how many of them failed, which is told on stderr
// and in a file of each. Error kinds: usage (nothing written); io, device and interrupted end it.
Result<std::size_t> run_sweep(const SweepOptions& options);

// Prints how far the sweep in `output` is, from its files. Error kinds: usage, io.
Status sweep_status(const SweepOptions& options);

// Writes the table of runs and the index. Error kinds: usage (runs are missing), io.
Status finalize_sweep(const SweepOptions& options);

// Writes the page of a finished data set. Error kinds: usage, io, interrupted.
Status report_command(const ReportOptions& options, bool quiet);

// Writes the page of a few pings at reduced cost. Error kinds: those of generate, and of
// write_report. With `watch` it ends by an interrupt, or where the page cannot be written.
Status preview(const PreviewOptions& options);

// Draws one ping, or a run of them. Error kinds: usage, io, interrupted.
Status figure_command(FigureOptions options, bool quiet);

// Makes the 8-bit images of a finished data set again. Error kinds: usage, io, interrupted.
Status render_command(RenderOptions options, bool quiet);

// All presets with their numbers, or the text of one.
Status presets(const std::optional<std::string>& name);

}  // namespace ensonify
