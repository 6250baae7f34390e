#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>

#include "app/bench_data_sets.h"
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/print.h"
#include "bench/bench.h"
#include "bench/machine.h"
#include "dataset/files.h"

namespace ensonify {
namespace {

void tell_progress(const std::string& what) { tell("measuring: {}\n", what); }

struct Chosen {
  std::vector<BenchCase> cases;
  std::vector<DataSetCase> data_sets;
};

// A name may stand for a case of both. Error (usage): it stands for none.
Result<Chosen> chosen_cases(const BenchCommandOptions& options) {
  Chosen chosen;
  std::vector<std::string> names;
  const auto is_chosen = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    return !options.case_name || *options.case_name == name;
  };
  if (options.only != "data_sets") {
    for (const BenchCase& c : bench_cases()) {
      if (is_chosen(c.name)) chosen.cases.push_back(c);
    }
  }
  if (options.only != "stages") {
    for (const DataSetCase& c : data_set_cases()) {
      if (is_chosen(c.name)) chosen.data_sets.push_back(c);
    }
  }
  if (!chosen.cases.empty() || !chosen.data_sets.empty()) return chosen;
  return Error{ErrorKind::usage, fmt::format("--case {}: expected one of {}", *options.case_name,
                                             fmt::join(names, ", "))};
}

Status measure_data_sets(const BenchCommandOptions& options, const std::vector<DataSetCase>& cases,
                         BenchReport& report) {
  if (cases.empty()) return {};
  // An interrupt ends a data set as it ends `generate`, so that its files are removed.
  listen_for_interrupts();
  const auto disk = options.disk.empty() ? std::filesystem::temp_directory_path() : options.disk;
  const Result<ScratchFolder> folder = ScratchFolder::make(disk);
  if (!folder) return folder.error();
  DataSetBenchOptions run;
  run.threads = options.threads;
  run.pings = options.pings;
  run.folder = folder->path();
  run.on_progress = tell_progress;
  for (const DataSetCase& c : cases) {
    Result<DataSetReport> measured = bench_data_set(c, run);
    if (!measured) return measured.error();
    report.data_sets.push_back(std::move(*measured));
  }
  return {};
}

}  // namespace

Status bench(const BenchCommandOptions& options) {
  Result<Chosen> chosen = chosen_cases(options);
  if (!chosen) return chosen.error();
  // Opened before minutes are spent.
  std::ofstream file;
  if (!options.json.empty()) {
    file.open(options.json, std::ios::binary);
    if (!file) return write_error(options.json, errno);
  }
  BenchOptions run;
  run.cases = std::move(chosen->cases);
  run.threads = options.threads;
  run.seconds = options.seconds;
  run.disk = options.disk;
  run.on_progress = tell_progress;
  Result<BenchReport> report = run_bench(run);
  if (!report) return report.error();
  const Status made = measure_data_sets(options, chosen->data_sets, *report);
  if (!made) return made;
  answer("{}", bench_text(*report));
  if (options.json.empty()) return {};
  file << bench_json(*report);
  file.close();
  return file ? Status() : Status(write_error(options.json, errno));
}

}  // namespace ensonify
