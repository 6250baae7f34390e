// The command `bench`: runs the measurements one after another and prints one report.
#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include "bench/machine.h"
#include "bench/report.h"
#include "cli/bench_cases.h"
#include "cli/commands.h"
#include "formats/files.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

void tell_progress(const std::string& what) { tell("measuring: {}\n", what); }

std::vector<TimedGroup> chosen_groups(const BenchCommandOptions& options,
                                      const std::filesystem::path& folder, int threads) {
  if (!options.input.scenario.empty()) {
    const std::string name = options.input.scenario.stem().string();
    return {{"scenario",
             options.input.scenario.string(),
             nullptr,
             {{name, options.input, options.threads, options.pings}}}};
  }
  std::vector<TimedGroup> groups = bench_groups(folder, threads, options.pings);
  std::erase_if(groups, [&](const TimedGroup& group) {
    return !options.only.empty() &&
           std::find(options.only.begin(), options.only.end(), group.name) == options.only.end();
  });
  return groups;
}

// Data sets are made in a folder that is removed afterward.
Result<BenchReport> measured_report(const BenchCommandOptions& options) {
  // An interrupt ends a data set as it would end `generate`, so that its files are removed.
  listen_for_interrupts();
  const auto disk = options.disk.empty() ? std::filesystem::temp_directory_path() : options.disk;
  const Result<ScratchFolder> folder = ScratchFolder::make(disk);
  if (!folder) return folder.error();
  if (Status written = write_bench_files(folder->path()); !written) return written.error();
  const int threads = Workers(options.threads).threads();
  BenchReport report;
  for (const TimedGroup& group : chosen_groups(options, folder->path(), threads)) {
    constexpr int kRuns = 3;
    Result<BenchTable> table = time_group(group, folder->path(), kRuns, tell_progress);
    if (!table) return table.error();
    report.tables.push_back(std::move(*table));
  }
  if (interrupted()) return Error{ErrorKind::interrupted, "interrupted"};
  tell_progress("machine");
  Result<MachineReport> machine = measure_machine(folder->path(), threads);
  if (!machine) return machine.error();
  report.machine = std::move(*machine);
  return report;
}

}  // namespace

std::vector<std::string> bench_group_names() {
  std::vector<std::string> names;
  for (const TimedGroup& group : bench_groups({}, 1, 1)) names.push_back(group.name);
  return names;
}

Status bench(const BenchCommandOptions& options) {
  // Reports a place that cannot be written before minutes are spent on measuring, and leaves the
  // content of an older file alone until there are results.
  if (!options.json.empty() && !std::ofstream(options.json, std::ios::binary | std::ios::app)) {
    return write_error(options.json, errno);
  }
  const Result<BenchReport> report = measured_report(options);
  if (!report) return report.error();
  answer("{}", bench_text(*report));
  if (options.json.empty()) return {};
  std::ofstream file(options.json, std::ios::binary);
  file << bench_json(*report);
  file.close();
  return file ? Status() : Status(write_error(options.json, errno));
}

}  // namespace ensonify
