#include "app/bench_data_sets.h"

#include <sys/resource.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/make_dataset.h"
#include "app/make_sequences.h"
#include "app/tables.h"
#include "bench/machine.h"
#include "core/stage_times.h"
#include "dataset/work.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Pixels of one view share their file of labels, so that expected level and elevation have no row
// of their own. Files that only some scenarios have (channels, ghosts, the distance field of a
// sequence) have none either.
constexpr FileKind kKinds[] = {
    {"series", "{polar: false, cartesian: false, png: false}"},
    {"series_exr", "{timeseries: both, polar: false, cartesian: false, png: false}"},
    {"polar", "{cartesian: false, png: false, shadow: false, amodal: false}"},
    {"polar_shadow", "{cartesian: false, png: false, amodal: false}"},
    {"polar_amodal", "{cartesian: false, png: false, shadow: false}"},
    {"polar_polygons",
     "{cartesian: false, png: false, shadow: false, amodal: false, polygons: true}"},
    {"cartesian",
     "{polar: false, cartesian: {exr: true}, png: false, shadow: false, amodal: false}"},
    {"png", "{polar: false, cartesian: false}"},
    {"scatterers", "{polar: false, cartesian: false, png: false, scatterers: true}"},
    {"points", "{polar: false, cartesian: false, png: false, points: true}"},
    {"layers", "{polar: false, cartesian: false, png: false, layers: true}"},
    {"default", "{}"},
    {"default_packed", "{one_file_per: sequence}"},
    {"every",
     "{timeseries: both, cartesian: {exr: true}, polygons: true, scatterers: true, points: true, "
     "layers: true}"}};

struct TimedRun {
  double pings_per_s = 0, core_ms_per_ping = 0, mb_per_ping = 0;
  std::array<double, kStageCount> stages_ms{};  // of a ping
};

// The time of all threads, with the system's work for them.
double core_ms() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto ms = [](const timeval& t) {
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_usec);
  };
  return ms(used.ru_utime) + ms(used.ru_stime);
}

Result<double> bytes_below(const fs::path& dir) {
  std::error_code error;
  double bytes = 0;
  for (auto i = fs::recursive_directory_iterator(dir, error); !error && i != fs::end(i);
       i.increment(error)) {
    if (i->is_regular_file(error)) bytes += static_cast<double>(i->file_size(error));
  }
  if (error) return read_error(dir, error.value());
  return bytes;
}

// As `generate` does it, once the world and the tables are there. The files stay.
Status make_data_set(const SequenceWorlds& worlds, const Numerics& numerics,
                     const DataSetBenchOptions& options, const fs::path& dir, PingRange pings,
                     PingRange sequences, StageTimes& stages) {
  const StopWatch watch;
  const Workers workers(options.threads);
  FileHashes hashes;
  Result<DatasetWork> work = settle_dataset(worlds, pings, sequences, numerics, hashes, workers);
  if (!work) return work.error();
  FolderUse use;
  const auto state =
      open_work(dir, work->identity, worlds.first().scenario.sequences, false, false, &use);
  if (!state) return state.error();
  Progress progress(ProgressStyle::quiet, 0, 0);
  Turns turns(workers.threads());
  const Crew crew{numerics, workers.threads(), turns, progress, nullptr, &stages};
  Status made = make_sequences(crew, dir, worlds, work->sequences());
  if (!made) return made;
  return finish_work(dir, worlds, std::move(*work), workers.threads(), watch.ms() / 1e3);
}

// One data set, whose folder is gone afterwards.
Result<TimedRun> run_once(const SequenceWorlds& worlds, const Numerics& numerics,
                          const DataSetBenchOptions& options, DataSetReport& report) {
  const Session& session = worlds.first();
  const auto each =
      static_cast<std::uint32_t>(std::min<std::size_t>(options.pings, session.ping_times_s.size()));
  const std::uint32_t sequences =
      std::min(session.scenario.sequences, (options.pings + each - 1) / each);
  report.beams = session.sonar.beam_count;
  report.samples = session.record.samples;
  report.pings = static_cast<int>(each * sequences);
  const auto tables = pipeline_tables(session, numerics);
  const fs::path dir = options.folder / "data_set";
  const StopWatch watch;
  const double core_before_ms = core_ms();
  StageTimes stages;
  const Status made =
      make_data_set(worlds, numerics, options, dir, {0, each}, {0, sequences}, stages);
  const double ms = watch.ms(), used_ms = core_ms() - core_before_ms;
  const Result<double> bytes = made ? bytes_below(dir) : Result<double>(made.error());
  std::error_code ignored;
  fs::remove_all(dir, ignored);
  if (!bytes) return bytes.error();
  TimedRun run{1e3 * report.pings / ms, used_ms / report.pings, *bytes / 1e6 / report.pings, {}};
  for (std::size_t s = 0; s < run.stages_ms.size(); ++s) {
    run.stages_ms[s] = 1e-6 * static_cast<double>(stages.ns[s]) / report.pings;
  }
  return run;
}

void add_stages(const std::vector<TimedRun>& runs, FileKindReport& report) {
  double rest_ms = report.core_ms_per_ping, physics_ms = 0;
  for (int s = 0; s < kStageCount; ++s) {
    std::vector<double> ms;
    for (const TimedRun& run : runs) ms.push_back(run.stages_ms[static_cast<std::size_t>(s)]);
    const auto stage = static_cast<Stage>(s);
    const double middle_ms = median(ms);
    report.stages.push_back({stage_name(stage), middle_ms});
    rest_ms -= middle_ms;
    if (is_physics(stage)) physics_ms += middle_ms;
  }
  report.stages.push_back({"rest", std::max(0.0, rest_ms)});
  report.physics_share = physics_ms / report.core_ms_per_ping;
}

FileKindReport summary_of(const FileKind& kind, const std::vector<TimedRun>& runs) {
  const auto all = [&](double TimedRun::*member) {
    std::vector<double> values;
    for (const TimedRun& run : runs) values.push_back(run.*member);
    return values;
  };
  const std::vector<double> rates = all(&TimedRun::pings_per_s);
  const auto [least, most] = std::minmax_element(rates.begin(), rates.end());
  FileKindReport report{kind.name,
                        median(rates),
                        *least,
                        *most,
                        median(all(&TimedRun::core_ms_per_ping)),
                        median(all(&TimedRun::mb_per_ping)),
                        {},
                        0};
  add_stages(runs, report);
  return report;
}

// Every kind once, then all of them again.
Result<DataSetReport> measure(std::string name, const ScenarioOptions& input,
                              std::span<const FileKind> kinds, const DataSetBenchOptions& options) {
  Result<Numerics> numerics = settle_backend(BackendChoice::cpu, best_simd_level());
  if (!numerics) return numerics.error();
  numerics->tables = std::make_shared<TableCache>();
  DataSetReport report;
  report.name = std::move(name);
  report.runs = options.runs;
  std::vector<std::vector<TimedRun>> runs(kinds.size());
  for (int i = 0; i < options.runs; ++i) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      if (options.on_progress) {
        options.on_progress(fmt::format("data set {}, run {} of {}: {}", report.name, i + 1,
                                        options.runs, kinds[k].name));
      }
      ScenarioOptions with_kind = input;
      if (kinds[k].output != nullptr) {
        with_kind.overrides.emplace_back("output", kinds[k].output);
      }
      const Result<SequenceWorlds> worlds = SequenceWorlds::open(with_kind);
      if (!worlds) return worlds.error();
      const Result<TimedRun> run = run_once(*worlds, *numerics, options, report);
      if (!run) return run.error();
      runs[k].push_back(*run);
    }
  }
  for (std::size_t k = 0; k < runs.size(); ++k) {
    report.kinds.push_back(summary_of(kinds[k], runs[k]));
  }
  return report;
}

}  // namespace

std::span<const FileKind> file_kinds() { return kKinds; }

Result<DataSetReport> bench_data_set(const DataSetCase& which, const DataSetBenchOptions& options) {
  const std::string name = std::string(which.name) + ".yaml";
  const auto written = write_file_atomically(options.folder, name, which.text);
  if (!written) return written.error();
  return measure(which.name, {options.folder / name, {}}, kKinds, options);
}

Result<DataSetReport> bench_scenario(const ScenarioOptions& input,
                                     const DataSetBenchOptions& options) {
  constexpr FileKind kOwn[] = {{"as it is", nullptr}};
  return measure(input.scenario.stem().string(), input, kOwn, options);
}

namespace {

void tell_progress(const std::string& what) { tell("measuring: {}\n", what); }

struct Chosen {
  std::vector<BenchCase> cases;
  std::vector<DataSetCase> data_sets;
};

// A name may stand for a case of both. Error (usage): it stands for none.
Result<Chosen> chosen_cases(const BenchCommandOptions& options) {
  Chosen chosen;
  if (!options.input.scenario.empty()) return chosen;
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
  const bool has_scenario = !options.input.scenario.empty();
  if (cases.empty() && !has_scenario) return {};
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
  const auto add = [&](Result<DataSetReport> measured) -> Status {
    if (!measured) return measured.error();
    report.data_sets.push_back(std::move(*measured));
    return {};
  };
  if (has_scenario) return add(bench_scenario(options.input, run));
  for (const DataSetCase& c : cases) {
    if (Status added = add(bench_data_set(c, run)); !added) return added;
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
