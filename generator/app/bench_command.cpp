#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <fstream>

#include "app/commands.h"
#include "app/print.h"
#include "bench/bench.h"
#include "dataset/files.h"

namespace ensonify {

Status bench(const BenchCommandOptions& options) {
  BenchOptions run;
  if (options.case_name) {
    std::erase_if(run.cases, [&](const BenchCase& c) { return c.name != *options.case_name; });
    if (run.cases.empty()) {
      std::string names;
      for (const BenchCase& c : bench_cases()) names += (names.empty() ? "" : ", ") + c.name;
      return Error{ErrorKind::usage,
                   fmt::format("--case {}: accepted is one of {}", *options.case_name, names)};
    }
  }
  // Opened before minutes are spent.
  std::ofstream file;
  if (!options.json.empty()) {
    file.open(options.json, std::ios::binary);
    if (!file) return write_error(options.json, errno);
  }
  run.threads = options.threads;
  run.seconds = options.seconds;
  run.disk = options.disk;
  run.on_progress = [](const std::string& what) { tell("measuring: {}\n", what); };
  const Result<BenchReport> report = run_bench(run);
  if (!report) return report.error();
  answer("{}", bench_text(*report));
  if (options.json.empty()) return {};
  file << bench_json(*report);
  file.close();
  return file ? Status() : Status(write_error(options.json, errno));
}

}  // namespace ensonify
