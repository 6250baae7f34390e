// The program's commands. Each returns nothing, or the error that the process ends with. Messages
// go to stderr, requested output (`check`, `presets`) to stdout.
//
//   generate finalize_dataset check verify export_command presets bench
//   list_sweep run_sweep sweep_status finalize_sweep
//   report_command preview figure_command render_command compare_command fit_command
//   import_command
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
#include "compare/run.h"
#include "core/error.h"
#include "core/runtime.h"
#include "export/export.h"
#include "figure/figure.h"
#include "recordings/import.h"
#include "render/render.h"
#include "report/report.h"
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

struct CheckOptions {
  ScenarioOptions input;
  std::filesystem::path output;  // of whose disk the free space is announced; empty: the working
                                 // folder's
  int threads = 0;
  BackendChoice backend = BackendChoice::automatic;
  SimdLevel simd = best_simd_level();
  bool all_worlds = false;  // builds the worlds of all sequences, not only of some
};

struct SweepOptions : MakeOptions {
  std::filesystem::path sweep;
  std::vector<Override> overrides;  // --set, of the base
};

struct BenchCommandOptions {
  ScenarioOptions input;       // measure only data sets of this scenario; empty: the cases
  std::filesystem::path json;  // empty: not written
  std::optional<std::string> case_name;
  std::string only;          // stages, data_sets or growth; empty: all
  std::uint32_t pings = 24;  // minimum for each data set
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
  bool watch = false;  // repeats whenever the scenario or a file that it names changes
  bool quiet = false;
};

// Writes the data set, or resumes it. Error kinds: usage (nothing written), io, interrupted.
Status generate(const GenerateOptions& options);

// Writes the top level of a data set whose sequences were made by shards. Error kinds: usage
// (sequences are missing, or the folder has other work), io.
Status finalize_dataset(const GenerateOptions& options);

// Prints the resolved scenario and, as comments below it, the cost of generating it, measured on a
// few pings.
Status check(const CheckOptions& options);

// Error kind damage if anything in the data set differs from its manifest.
Status verify(const std::filesystem::path& folder, int threads);

// Converts a finished data set to another format. Error kinds: usage (for an unknown format with
// the nearest one), io, interrupted.
Status export_command(const std::string& format, ExportOptions options, bool quiet);
// Name and description of each format, one per line.
std::string export_format_list();

// Prints the speed of this machine by stage and for whole data sets, and the growth of the latter.
// Error kinds: usage, io, interrupted.
Status bench(const BenchCommandOptions& options);
// The names of everything that it measures without a scenario.
std::vector<std::string> bench_case_names();

// Prints the plan of a sweep with the cost of each run, and writes nothing. Error kinds: usage
// (also if the plan in the folder has runs that this one does not have), io.
Status list_sweep(const SweepOptions& options);

// Makes the missing runs of the shard and returns how many of them failed; failures are reported on
// stderr and in a file for each. Error kinds: usage (nothing written); io, device and interrupted
// end the sweep.
Result<std::size_t> run_sweep(const SweepOptions& options);

// Prints the progress of the sweep in `output`, from its files. Error kinds: usage, io.
Status sweep_status(const SweepOptions& options);

// Writes the table of runs and the index. Error kinds: usage (runs are missing), io. With
// `leave_missing`, missing runs are no error and nothing is written: another process that looks
// into a finished run has it open for a moment, and writes the tables itself.
Status finalize_sweep(const SweepOptions& options, bool leave_missing = false);

// Writes the page of a finished data set. Error kinds: usage, io, interrupted.
Status report_command(const ReportOptions& options, bool quiet);

// Writes the page of a few pings at reduced cost. Error kinds: those of generate and of
// write_report. With `watch` it ends on an interrupt, or if the page cannot be written.
Status preview(const PreviewOptions& options);

// Prints the table of a comparison of two data sets, or folders of crops. Error kinds: usage, io,
// interrupted.
Status compare_command(CompareOptions options, bool quiet);

struct FitOptions {
  ScenarioOptions scenario;
  std::filesystem::path recording;  // a data set
  std::filesystem::path output;     // a folder: evaluations.jsonl, fit.json, card.yaml
  std::vector<std::string> keys;    // of parse_key (fit/fit_text.h)
  Amount amount;
  std::filesystem::path mask;  // of the recording; empty: none
  int max_simulations = 400;   // of the search
  int threads = 0;
  bool overwrite = false;  // forgets earlier simulations in the folder
  bool quiet = false;
  bool (*stop)() = nullptr;
};

// Fits keys of a scenario to a recording and prints their table. Goes on with an interrupted fit.
// Error kinds: those of generate; usage, io, interrupted.
Status fit_command(FitOptions options);

// Draws one ping, or a range of them. Error kinds: usage, io, interrupted.
Status figure_command(FigureOptions options, bool quiet);

// Makes the 8-bit images of a finished data set again. Error kinds: usage, io, interrupted.
Status render_command(RenderOptions options, bool quiet);

// Makes a data set from a log of a real sonar, or resumes it. Error kinds: usage (nothing written),
// io, interrupted.
Status import_command(ImportOptions options, bool quiet);

// Prints all presets with their numbers, or the text of one.
Status presets(const std::optional<std::string>& name);

}  // namespace ensonify
