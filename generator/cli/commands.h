// The program's commands. Each returns nothing, or the error that the process ends with. Messages
// go to stderr, requested output (`check`, `presets`) to stdout.
//
//   check verify export_command presets bench   (run/runs.h has generate and sweeps)
//   report_command preview figure_command render_command compare_command fit_command
//   import_command
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/run.h"
#include "core/error.h"
#include "export/export.h"
#include "figure/figure.h"
#include "recordings/import.h"
#include "render/render.h"
#include "report/report.h"
#include "run/options.h"
#include "run/runs.h"

namespace ensonify {

struct CheckOptions {
  ScenarioOptions input;
  std::filesystem::path output;  // of whose disk the free space is announced; empty: the working
                                 // folder's
  int threads = 0;
  BackendChoice backend = BackendChoice::automatic;
  SimdLevel simd = best_simd_level();
  bool all_worlds = false;  // builds the worlds of all sequences, not only of some
};

struct BenchCommandOptions {
  ScenarioOptions input;          // measure only data sets of this scenario; empty: the groups
  std::filesystem::path json;     // empty: not written
  std::vector<std::string> only;  // of bench_group_names; empty: all
  std::uint32_t pings = 24;       // minimum for each data set
  int threads = 0;
  std::filesystem::path disk;  // where data sets are made; empty: the system's temporary folder
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

// Prints the speed of making whole data sets on this machine, in tables. Error kinds: usage, io,
// interrupted.
Status bench(const BenchCommandOptions& options);
// The names of the tables that it prints without a scenario.
std::vector<std::string> bench_group_names();

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
  std::vector<std::string> keys;    // of parse_key (fit/key_text.h)
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
