#include "app/timed_data_set.h"

#include <sys/resource.h>

#include <fmt/format.h>

#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "app/make_dataset.h"
#include "app/make_sequences.h"
#include "app/prepare_session.h"
#include "app/session.h"
#include "bench/machine.h"
#include "dataset/work.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct Spent {
  StopWatch watch;
  double core_before_ms = core_ms();
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
                           const BenchSite& site, const fs::path& dir, SharedParts first,
                           StageTimes& stages) {
  const StopWatch watch;
  const Workers workers(site.threads);
  FileHashes hashes;
  Result<DatasetWork> work = settle_dataset(worlds, plan.pings, {}, site.numerics, hashes);
  if (!work) return work.error();
  FolderUse use;
  const auto state =
      open_work(dir, work->identity, worlds.first().scenario.sequences, false, false, &use);
  if (!state) return state.error();
  Progress progress(ProgressStyle::quiet, 0, 0);
  Turns turns(workers.threads());
  const Crew crew{site.numerics, workers.threads(), turns, progress, nullptr, &stages};
  const Status settled = settle_display(dir, worlds, site.numerics, workers, *work, first);
  if (!settled) return settled.error();
  const Status made = make_sequences(crew, dir, worlds, *work, 1, {}, std::move(first));
  if (!made) return made.error();
  const std::vector<SequenceFailure> failed = failures_of(dir, *work);
  if (!failed.empty()) return Error{ErrorKind::usage, failures_text(failed, work->asked_count())};
  const auto pings = static_cast<int>(ping_totals(dir, worlds, *work).found);
  const auto finished =
      finish_work(dir, worlds, std::move(*work), workers.threads(), watch.ms() / 1e3);
  if (!finished) return finished.error();
  return pings;
}

// Measures from `spent` until the data set is finished, then removes its folder.
Result<TimedDataSet> timed_until_finished(const Spent& spent, const SequenceWorlds& worlds,
                                          const DataSetPlan& plan, const BenchSite& site,
                                          SharedParts first, StageTimes& stages) {
  const fs::path dir = site.folder / "data_set";
  const Result<int> pings = make_and_count(worlds, plan, site, dir, std::move(first), stages);
  const double ms = spent.watch.ms(), used_ms = core_ms() - spent.core_before_ms;
  const Result<double> bytes = pings ? bytes_below(dir) : Result<double>(pings.error());
  std::error_code ignored;
  fs::remove_all(dir, ignored);
  if (!bytes) return bytes.error();
  const Session& session = worlds.first();
  TimedDataSet timed{session.sonar.beam_count, session.record.samples, *pings, 1e3 * *pings / ms,
                     used_ms / *pings,         *bytes / 1e6 / *pings,  {}};
  for (std::size_t s = 0; s < timed.stages_ms.size(); ++s) {
    timed.stages_ms[s] = 1e-6 * static_cast<double>(stages.ns[s]) / *pings;
  }
  return timed;
}

}  // namespace

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

Result<TimedDataSet> time_in_world(const SequenceWorlds& worlds, const DataSetPlan& plan,
                                   const BenchSite& site) {
  SharedParts first;
  first.tables = pipeline_tables(worlds.first(), site.numerics);
  StageTimes stages;
  return timed_until_finished(Spent(), worlds, plan, site, std::move(first), stages);
}

Result<TimedDataSet> time_data_set(const DataSetPlan& plan, const BenchSite& site) {
  if (!plan.times_worlds) {
    const Result<SequenceWorlds> worlds = SequenceWorlds::open(plan.input);
    if (!worlds) return worlds.error();
    return time_in_world(*worlds, plan, site);
  }
  // `generate` does not have the tables of an earlier run.
  BenchSite alone = site;
  alone.numerics.tables = std::make_shared<TableCache>();
  StageTimes stages;
  const Spent spent;
  const Result<SequenceWorlds> worlds =
      timed(Workers(1, &stages), Stage::world, [&] { return SequenceWorlds::open(plan.input); });
  if (!worlds) return worlds.error();
  return timed_until_finished(spent, *worlds, plan, alone, {}, stages);
}

}  // namespace ensonify
