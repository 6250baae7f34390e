#include "cli/timed_data_set.h"

#include <sys/resource.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <system_error>
#include <utility>
#include <variant>

#include "bench/machine.h"
#include "core/stage_times.h"
#include "dataset/work.h"
#include "formats/files.h"
#include "ping/prepare_session.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "run/live_sequence.h"
#include "run/make_dataset.h"
#include "run/make_sequences.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Includes all threads, importer processes that have ended, and the system's work for both.
double core_ms() {
  const auto ms = [](const timeval& t) {
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_usec);
  };
  double sum = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    sum += ms(used.ru_utime) + ms(used.ru_stime);
  }
  return sum;
}

struct Spent {
  StopWatch watch;
  double core_before_ms = core_ms();
};

BenchSizes bench_sizes(const Session& session, int threads) {
  const Sonar& sonar = session.sonar;
  BenchSizes sizes;
  sizes.threads = threads;
  sizes.beams = sonar.beam_count;
  sizes.samples = session.record.samples;
  sizes.rays = sizes.beams * sonar.rays_azimuth * sonar.rays_elevation;
  sizes.objects = static_cast<double>(session.world.instances.size());
  for (const WorldObject& object : session.world.objects) {
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape != nullptr) sizes.triangles += static_cast<double>(shape->mesh->triangles.size());
  }
  return sizes;
}

// One run of a case.
struct TimedRun {
  BenchSizes sizes;
  int pings = 0;
  double pings_per_s = 0, core_ms_per_ping = 0, mb_per_ping = 0, world_core_ms = 0;
  std::array<double, kStageCount> stages_ms{};  // per ping
};

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

// Makes the data set and returns the number of its pings. The files stay.
Result<int> make_and_count(const SequenceWorlds& worlds, const DataSetPlan& plan,
                           const Numerics& numerics, int threads, const fs::path& dir,
                           SharedParts first, StageTimes& stages) {
  const StopWatch watch;
  const Workers workers(threads);
  FileHashes hashes;
  Result<DatasetWork> work = settle_dataset(worlds, plan.pings, {}, numerics, hashes);
  if (!work) return work.error();
  FolderUse use;
  const auto state =
      open_work(dir, work->identity, worlds.first().scenario.sequences, false, false, &use);
  if (!state) return state.error();
  Progress progress(ProgressStyle::quiet, 0, 0);
  Turns turns(workers.threads());
  const Crew crew{numerics, workers.threads(), turns, progress, nullptr, &stages};
  const Status settled = settle_display(dir, worlds, numerics, workers, *work, first);
  if (!settled) return settled.error();
  SequenceJob job{crew, dir, worlds, *work, std::move(first)};
  const Status made = make_sequences({&job, 1});
  if (!made) return made.error();
  const std::vector<SequenceFailure> failed = failures_of(dir, *work);
  if (!failed.empty()) return Error{ErrorKind::usage, failures_text(failed, work->asked_count())};
  const auto pings = static_cast<int>(ping_totals(dir, worlds, *work).found);
  const auto finished =
      finish_work(dir, worlds, std::move(*work), workers.threads(), watch.ms() / 1e3);
  if (!finished) return finished.error();
  return pings;
}

Result<TimedRun> time_run(const TimedCase& timed_case, const fs::path& folder, Numerics numerics) {
  const Result<DataSetPlan> plan = plan_data_set(timed_case.input, timed_case.pings);
  if (!plan) return plan.error();
  StageTimes stages;
  Spent spent;
  const Result<SequenceWorlds> worlds =
      timed(Workers(1, &stages), Stage::world, [&] { return SequenceWorlds::open(plan->input); });
  if (!worlds) return worlds.error();
  const double world_core_ms = core_ms() - spent.core_before_ms;
  SharedParts first;
  if (plan->times_worlds) {
    // `generate` does not have the tables of an earlier run.
    numerics.tables = std::make_shared<TableCache>();
  } else {
    first.tables = pipeline_tables(worlds->first(), numerics);
    stages.ns[static_cast<std::size_t>(Stage::world)] = 0;
    spent = Spent();
  }
  const int threads = Workers(timed_case.threads).threads();
  const fs::path dir = folder / "data_set";
  const Result<int> pings =
      make_and_count(*worlds, *plan, numerics, threads, dir, std::move(first), stages);
  const double ms = spent.watch.ms(), used_ms = core_ms() - spent.core_before_ms;
  const Result<double> bytes = pings ? bytes_below(dir) : Result<double>(pings.error());
  std::error_code ignored;
  fs::remove_all(dir, ignored);
  if (!bytes) return bytes.error();
  TimedRun run{bench_sizes(worlds->first(), threads),
               *pings,
               1e3 * *pings / ms,
               used_ms / *pings,
               *bytes / 1e6 / *pings,
               world_core_ms,
               {}};
  for (std::size_t s = 0; s < run.stages_ms.size(); ++s) {
    run.stages_ms[s] = 1e-6 * static_cast<double>(stages.ns[s]) / *pings;
  }
  return run;
}

BenchRow summary_of(const TimedCase& timed_case, const std::vector<TimedRun>& runs) {
  const auto all = [&](double TimedRun::*member) {
    std::vector<double> values;
    for (const TimedRun& run : runs) values.push_back(run.*member);
    return values;
  };
  const std::vector<double> rates = all(&TimedRun::pings_per_s);
  const auto [least, most] = std::minmax_element(rates.begin(), rates.end());
  BenchRow row{timed_case.name,
               runs.back().sizes,
               runs.back().pings,
               median(rates),
               *least,
               *most,
               median(all(&TimedRun::core_ms_per_ping)),
               median(all(&TimedRun::mb_per_ping)),
               median(all(&TimedRun::world_core_ms))};
  double rest_ms = row.core_ms_per_ping, physics_ms = 0;
  for (int s = 0; s < kStageCount; ++s) {
    std::vector<double> ms;
    for (const TimedRun& run : runs) ms.push_back(run.stages_ms[static_cast<std::size_t>(s)]);
    const auto stage = static_cast<Stage>(s);
    const double middle_ms = median(std::move(ms));
    row.stages.push_back({stage_name(stage), middle_ms});
    rest_ms -= middle_ms;
    if (is_physics(stage)) physics_ms += middle_ms;
  }
  row.stages.push_back({"rest", std::max(0.0, rest_ms)});
  row.physics_share = physics_ms / row.core_ms_per_ping;
  return row;
}

Result<PingResult> first_ping(const ScenarioOptions& input, BackendChoice backend,
                              const Workers& workers) {
  const auto source = open_source(input, backend);
  if (!source) return source.error();
  const auto sequence =
      open_sequence(**source, 0, (*source)->worlds.first().scenario.output.selection, workers);
  if (!sequence) return sequence.error();
  return live_ping(**sequence, 0, workers);
}

// Ping 0 by both backends, without noise, which is the same in both.
Result<SeriesError> measured_error(const TimedCase& timed_case) {
  ScenarioOptions input = timed_case.input;
  input.overrides.push_back({"noise", "{spectrum_level_db: -300}"});
  for (const Override& key : *timed_case.compared) input.overrides.push_back(key);
  const Workers workers(timed_case.threads);
  const auto fast = first_ping(input, BackendChoice::cpu, workers);
  if (!fast) return fast.error();
  const auto exact = first_ping(input, BackendChoice::reference, workers);
  if (!exact) return exact.error();
  return series_error(fast->series, exact->series, static_cast<int>(exact->first_return_m.size()));
}

}  // namespace

Result<DataSetPlan> plan_data_set(const ScenarioOptions& input, std::uint32_t pings) {
  const Result<std::string> text = read_scenario_text(input.scenario);
  if (!text) return text.error();
  const std::string label = input.scenario.string();
  Result<Scenario> scenario =
      parse_scenario(*text, label, input.scenario.parent_path(), input.overrides);
  if (!scenario) return scenario.error();
  const Result<Session> session = prepare_without_world(std::move(*scenario), 0);
  if (!session) return with_place(session.error(), *text, label, input.overrides);
  const auto in_sequence = static_cast<std::uint32_t>(session->ping_times_s.size());
  DataSetPlan plan{input, {}, false};
  const std::uint32_t sequences = (pings + in_sequence - 1) / in_sequence;
  if (pings < in_sequence) plan.pings = PingRange{0, pings};
  plan.input.overrides.push_back({"sequences", std::to_string(sequences)});
  plan.times_worlds = sequences > 1 && varies_by_sequence(session->scenario);
  return plan;
}

Result<BenchTable> time_group(const TimedGroup& group, const fs::path& folder, int runs,
                              const std::function<void(const std::string&)>& on_progress) {
  Result<Numerics> numerics = settle_backend(BackendChoice::cpu, best_simd_level());
  if (!numerics) return numerics.error();
  numerics->tables = std::make_shared<TableCache>();
  // A data set ends by itself when it is interrupted, a comparison does not.
  const auto begin = [&](const std::string& what, const TimedCase& which) -> Status {
    if (interrupted()) return Error{ErrorKind::interrupted, "interrupted"};
    if (on_progress) on_progress(fmt::format("{}, {}: {}", group.name, what, which.name));
    return {};
  };
  std::vector<std::vector<TimedRun>> timed_runs(group.cases.size());
  for (int i = 0; i < runs; ++i) {
    for (std::size_t c = 0; c < group.cases.size(); ++c) {
      const Status begun = begin(fmt::format("run {} of {}", i + 1, runs), group.cases[c]);
      if (!begun) return begun.error();
      const Result<TimedRun> run = time_run(group.cases[c], folder, *numerics);
      if (!run) return run.error();
      timed_runs[c].push_back(*run);
    }
  }
  BenchTable table{group.name, group.title, group.grows, runs};
  for (std::size_t c = 0; c < group.cases.size(); ++c) {
    table.rows.push_back(summary_of(group.cases[c], timed_runs[c]));
    if (!group.cases[c].compared) continue;
    if (Status begun = begin("error", group.cases[c]); !begun) return begun.error();
    const Result<SeriesError> error = measured_error(group.cases[c]);
    if (!error) return error.error();
    table.rows.back().error = *error;
  }
  return table;
}

}  // namespace ensonify
