// The command `bench`: selects the measurements, runs them one after another and prints one report.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include "app/bench_data_sets.h"
#include "app/bench_growth.h"
#include "app/commands.h"
#include "app/terminal.h"
#include "bench/machine.h"
#include "formats/files.h"

namespace ensonify {
namespace {

void tell_progress(const std::string& what) { tell("measuring: {}\n", what); }

// Returns each name once.
template <class Items>
void add_names(const Items& items, std::vector<std::string>& names) {
  for (const auto& item : items) {
    if (std::find(names.begin(), names.end(), item.name) == names.end()) {
      names.emplace_back(item.name);
    }
  }
}

struct Chosen {
  std::vector<BenchCase> cases;
  std::vector<DataSetCase> data_sets;
  std::vector<GrowthAxis> growth;
};

// One name may select both a stage case and a data set. Error (usage): no measurement has the name.
Result<Chosen> chosen_cases(const BenchCommandOptions& options) {
  Chosen chosen;
  if (!options.input.scenario.empty()) return chosen;
  std::vector<std::string> names;
  const auto choose = [&](const char* what, const auto& all, auto& taken) {
    if (!options.only.empty() && options.only != what) return;
    add_names(all, names);
    for (const auto& item : all) {
      if (!options.case_name || *options.case_name == item.name) taken.push_back(item);
    }
  };
  choose("stages", bench_cases(), chosen.cases);
  choose("data_sets", data_set_cases(), chosen.data_sets);
  choose("growth", growth_axes(Workers(options.threads).threads()), chosen.growth);
  if (!chosen.cases.empty() || !chosen.data_sets.empty() || !chosen.growth.empty()) return chosen;
  return Error{ErrorKind::usage, fmt::format("--case {}: expected one of {}", *options.case_name,
                                             fmt::join(names, ", "))};
}

Status measure_data_sets(const BenchCommandOptions& options, const std::vector<DataSetCase>& cases,
                         const std::filesystem::path& folder, BenchReport& report) {
  DataSetBenchOptions run;
  run.threads = options.threads;
  run.pings = options.pings;
  run.folder = folder;
  run.on_progress = tell_progress;
  const auto add = [&](Result<DataSetReport> measured) -> Status {
    if (!measured) return measured.error();
    report.data_sets.push_back(std::move(*measured));
    return {};
  };
  if (!options.input.scenario.empty()) return add(bench_scenario(options.input, run));
  const DataSetCase& by_kind = data_set_cases().front();
  for (const DataSetCase& c : cases) {
    const auto kinds = c.name == by_kind.name ? file_kinds() : own_files();
    if (Status added = add(bench_data_set(c, kinds, run)); !added) return added;
  }
  return {};
}

Status measure_growth(const std::vector<GrowthAxis>& axes, const std::filesystem::path& folder,
                      BenchReport& report) {
  GrowthBenchOptions run;
  run.folder = folder;
  run.on_progress = tell_progress;
  for (const GrowthAxis& axis : axes) {
    Result<GrowthReport> measured = bench_growth(data_set_cases().front(), axis, run);
    if (!measured) return measured.error();
    report.growth.push_back(std::move(*measured));
  }
  return {};
}

// Measures whole data sets, from scene to disk, in a folder that is removed afterward.
Status measure_whole(const BenchCommandOptions& options, const Chosen& chosen,
                     BenchReport& report) {
  // An interrupt ends a data set as it would end `generate`, so that its files are removed.
  listen_for_interrupts();
  const auto disk = options.disk.empty() ? std::filesystem::temp_directory_path() : options.disk;
  const Result<ScratchFolder> folder = ScratchFolder::make(disk);
  if (!folder) return folder.error();
  Status made = measure_data_sets(options, chosen.data_sets, folder->path(), report);
  return made ? measure_growth(chosen.growth, folder->path(), report) : made;
}

}  // namespace

std::vector<std::string> bench_case_names() {
  std::vector<std::string> names;
  add_names(bench_cases(), names);
  add_names(data_set_cases(), names);
  add_names(growth_axes(1), names);
  return names;
}

Status bench(const BenchCommandOptions& options) {
  Result<Chosen> chosen = chosen_cases(options);
  if (!chosen) return chosen.error();
  // Reports a place that cannot be written before minutes are spent on measuring, and leaves the
  // content of an older file alone until there are results.
  if (!options.json.empty() && !std::ofstream(options.json, std::ios::binary | std::ios::app)) {
    return write_error(options.json, errno);
  }
  BenchOptions run;
  run.cases = chosen->cases;
  run.threads = options.threads;
  run.seconds = options.seconds;
  run.disk = options.disk;
  run.on_progress = tell_progress;
  Result<BenchReport> report = run_bench(run);
  if (!report) return report.error();
  if (Status made = measure_whole(options, *chosen, *report); !made) return made;
  answer("{}", bench_text(*report));
  if (options.json.empty()) return {};
  std::ofstream file(options.json, std::ios::binary);
  file << bench_json(*report);
  file.close();
  return file ? Status() : Status(write_error(options.json, errno));
}

}  // namespace ensonify
