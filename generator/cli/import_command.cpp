#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/command_line_views.h"
#include "core/counted.h"
#include "run/make_dataset.h"
#include "run/program.h"
#include "run/terminal.h"

namespace ensonify {

void add_import(CLI::App& app, ViewArguments& arguments) {
  CLI::App& command = *app.add_subcommand(
      "import", "make a data set without labels from a recording of a real sonar");
  ImportOptions& options = arguments.imported;
  command
      .add_option("LOG", options.log,
                  "log of an ARIS (.aris) or Oculus (.oculus) sonar, ROS 2 recording (.mcap), "
                  "folder of polar or display images with a recording.yaml, or set of neusis, "
                  "HoloOcean or SonarSplat (Config.json, Data/*.pkl)")
      ->required();
  command.add_option("-o,--output", options.output, "folder of the data set")->required();
  command.add_option("--pings", arguments.imported_pings,
                     "A:B: only frames A to B-1 of the log; default: all");
  command.add_option("--name", options.name,
                     "name of the data set; default: that of the log, without its extension");
  command
      .add_option("--split", options.split, "split of all sequences: train (default), val or test")
      ->check(CLI::IsMember({"train", "val", "test"}));
  command
      .add_option("--height-px", options.cartesian_height_px,
                  "rows of the Cartesian images; default: 1000")
      ->check(CLI::Range(1, 16384));
  command.add_option("--topic", options.choices.topic,
                     "MCAP: topic of the sonar images; default: the first one");
  command.add_option(
      "--db", arguments.imported_db,
      "MCAP: MIN:MAX: the counts are levels in dB, from 0 to full scale; default: as "
      "TOPIC/info (SonarInfo) says, or else amplitudes");
  command
      .add_option("--frequency-hz", options.choices.frequency_hz,
                  "sets of neusis: frequency of the sonar; default: 1e6")
      ->check(CLI::Range(1.0, 1e9));
  command.add_option("--threads", options.threads, "threads; 0 uses all cores")
      ->check(CLI::Range(0, 4096));
  command.add_flag("--overwrite", options.overwrite,
                   "replace another data set; removes only files that its manifest lists");
  command.add_flag("--quiet", arguments.quiet, "print only errors and warnings");
}

Status run_import(const ViewArguments& arguments) {
  ImportOptions options = arguments.imported;
  if (!arguments.imported_pings.empty()) {
    const auto pings = parse_range("--pings", arguments.imported_pings);
    if (!pings) return pings.error();
    options.pings = *pings;
  }
  if (!arguments.imported_db.empty()) {
    const auto db = parse_levels("--db", arguments.imported_db);
    if (!db) return db.error();
    options.choices.db = *db;
  }
  return import_command(std::move(options), arguments.quiet);
}

Status import_command(ImportOptions options, bool quiet) {
  expect_interrupts();
  options.listen = listen_for_interrupts;
  options.stop = interrupted;
  options.program_version = program_version();
  options.program_commit = program_commit();
  options.host = host_name();
  const auto report = import_log(options);
  if (!report) return report.error();
  for (const std::string& warning : report->warnings) tell("warning: {}\n", warning);
  if (quiet) return {};
  if (report->complete) {
    tell("{}: already complete, nothing to do\n", options.output.string());
    return {};
  }
  tell("{}: {} of {} ({})\n", options.output.string(), counted(report->pings, "ping"),
       counted(report->sequences, "sequence"), report->instrument);
  if (report->sequences > 1) {
    tell("{}: a new sequence begins where the settings of the sonar change\n",
         options.output.string());
  }
  return {};
}

}  // namespace ensonify
