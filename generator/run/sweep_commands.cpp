#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "core/counted.h"
#include "dataset/layout.h"
#include "formats/files.h"
#include "run/cost.h"
#include "run/options.h"
#include "run/program.h"
#include "run/runs.h"
#include "run/sweep_time.h"
#include "run/terminal.h"
#include "scenario/text.h"
#include "sweep/expand.h"
#include "sweep/folder.h"
#include "sweep/index.h"
#include "sweep/shards.h"
#include "sweep/status.h"

namespace ensonify {
namespace {

void print_row(const SweepRun& run) {
  answer("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", run.id, run.cost.pings, run.cost.files,
         bytes_text(run.cost.disk_bytes), seconds_text(run.cost.core_s), run.name);
}

Cost sum_of(const Sweep& sweep, const std::vector<std::size_t>& runs) {
  Cost sum;
  for (const std::size_t run : runs) {
    const Cost& cost = sweep.runs[run].cost;
    sum.pings += cost.pings;
    sum.files += cost.files;
    sum.disk_bytes += cost.disk_bytes;
    sum.core_s += cost.core_s;
  }
  return sum;
}

std::string without(const Sweep& sweep) {
  std::string text;
  if (sweep.left_out > 0) text += fmt::format(", {} skipped by skip_if", sweep.left_out);
  if (sweep.repeated > 0) text += fmt::format(", {} identical to another", sweep.repeated);
  return text;
}

// Batch scripts list shards on machines that do not make them, so nothing is measured for a shard.
void announce_time(const Sweep& sweep, const std::vector<std::size_t>& runs,
                   const SweepOptions& options) {
  if (options.shard) return;
  const auto measured = measured_time(sweep, runs, options);
  if (!measured) {
    answer("# time: not measured; no run of typical cost is short and small enough\n");
    return;
  }
  const auto threads = static_cast<std::uint64_t>(Workers(options.threads).threads());
  answer("# time: about {} with {}, {} of one core; disk: about {} (measured: pings of {})\n",
         seconds_text(measured->time.wall_s), counted(threads, "thread"),
         seconds_text(measured->time.core_s),
         bytes_text(static_cast<std::uint64_t>(measured->disk_bytes)),
         counted(measured->measured, "run"));
}

// Compares the plan with that in the folder. Error: the sweep itself would be refused.
Status print_change(const SweepOptions& options, const std::string& name, const Plan& plan) {
  const SweepHead head{name, program_version(), program_commit()};
  const auto change = look_at_sweep_folder(options.output, head, plan, options.overwrite);
  if (!change) return change.error();
  if (!*change) return {};
  answer("# {}: {} of these runs are in its plan, {} are new\n", options.output.string(),
         (*change)->kept, (*change)->added);
  return {};
}

}  // namespace

Status list_sweep(const SweepOptions& options) {
  Result<SweepFile> file = load_sweep_file(options.sweep, options.overrides);
  if (!file) return file.error();
  const Workers workers(options.threads);
  const Result<Sweep> sweep = expand_sweep(std::move(*file), run_cost, workers);
  if (!sweep) return sweep.error();
  const Plan plan = plan_of(*sweep);
  const std::vector<std::size_t> runs = runs_of_shard(plan, options.shard.value_or(Shard{}));
  answer("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", "run", "pings", "files", "disk", "core", "name");
  for (const std::size_t run : runs) print_row(sweep->runs[run]);
  const Cost sum = sum_of(*sweep, runs);
  const std::string part = options.shard ? fmt::format(" of {} in shard {}/{}", plan.size(),
                                                       options.shard->number, options.shard->count)
                                         : std::string();
  answer("# {}: {}{}{}\n", sweep->file.name, counted(runs.size(), "run"), part, without(*sweep));
  answer("# {}, {}, about {} on disk and {} of a core\n", counted(sum.pings, "ping"),
         counted(sum.files, "file"), bytes_text(sum.disk_bytes), seconds_text(sum.core_s));
  announce_time(*sweep, runs, options);
  return options.output.empty() ? Status() : print_change(options, sweep->file.name, plan);
}

namespace {

namespace fs = std::filesystem;

struct Begun {
  SweepHead head;
  Plan plan;
};

// The sweep as its folder describes it, even if its file has changed.
Result<Begun> begun_sweep(const fs::path& dir) {
  auto head = read_sweep_head(dir);
  if (!head) return head.error();
  auto plan = read_plan(dir);
  if (!plan) return plan.error();
  if (*head && *plan) return Begun{std::move(**head), std::move(**plan)};
  return Error{ErrorKind::usage, fmt::format("{}: not the folder of a sweep; expected the folder "
                                             "that `ensonify sweep SWEEP -o DIR` writes to",
                                             dir.string())};
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::vector<RunStatus> all_statuses(const fs::path& dir, const Plan& plan, double now_s,
                                    const Workers& workers) {
  std::vector<RunStatus> statuses(plan.size());
  workers.for_each(plan.size(),
                   [&](std::size_t i) { statuses[i] = run_status(dir, plan[i], now_s); });
  return statuses;
}

// Failed runs count as missing, because their data does not exist.
Status refuse_missing(const fs::path& dir, const SweepStatus& status) {
  if (status.done == status.runs) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "{}: {} of {} runs are not done ({} failed, {} running, {} missing); repeat the command "
          "of the sweep, or give --partial to finish without them; nothing was written",
          dir.string(), status.runs - status.done, status.runs, status.failed, status.begun,
          status.missing)};
}

// A damaged run counts as a failure, because the sweep itself does not touch finished runs.
FinishedRun damaged_run(const PlannedRun& run, const Error& error) {
  FinishedRun finished;
  finished.state = RunState::damaged;
  finished.failure =
      RunFailure{run.id, run.name, kind_name(ErrorKind::damage), error.message, "", ""};
  return finished;
}

Status refuse_damaged(const fs::path& dir, const Plan& plan, const std::vector<FinishedRun>& runs) {
  constexpr std::size_t kMostNamed = 10;
  std::size_t count = 0;
  std::string named;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].state != RunState::damaged || ++count > kMostNamed) continue;
    named += fmt::format("\n  {}: {}", run_folder(plan[i].id), one_line(runs[i].failure->message));
  }
  if (count == 0) return {};
  if (count > kMostNamed) named += "\n  ...";
  return Error{ErrorKind::io,
               fmt::format("{}: {} of {} runs are damaged; remove their folders and repeat the "
                           "command of the sweep, or give --partial to finish without them{}",
                           dir.string(), count, runs.size(), named)};
}

Result<FinishedRun> finished_run(const fs::path& dir, const PlannedRun& run,
                                 const RunStatus& status) {
  FinishedRun finished;
  finished.state = status.state;
  finished.failure = status.failure;
  if (status.state != RunState::done) return finished;
  const fs::path folder = dir / run_folder(run.id);
  const auto hash = sha256_of_file(folder / layout::kDatasetJson);
  if (!hash) return hash.error();
  finished.dataset_sha256 = *hash;
  const auto results = read_results(folder);
  if (!results) return results.error();
  finished.results = *results;
  return finished;
}

Status write_tables(const fs::path& dir, const Begun& sweep, const std::vector<FinishedRun>& runs) {
  const auto table = write_file_atomically(dir, kRunsFile, runs_csv(sweep.plan, runs));
  if (!table) return table.error();
  const auto index =
      write_file_atomically(dir, kIndexFile, index_json(sweep.head, sweep.plan, runs));
  close_sweep_folder(dir);
  return index ? Status() : Status(index.error());
}

}  // namespace

Status sweep_status(const SweepOptions& options) {
  Result<Begun> sweep = begun_sweep(options.output);
  if (!sweep) return sweep.error();
  if (options.shard) {
    Plan part;
    for (const std::size_t i : runs_of_shard(sweep->plan, *options.shard)) {
      part.push_back(sweep->plan[i]);
    }
    sweep->plan = std::move(part);
  }
  const double now = now_s();
  const auto runs = all_statuses(options.output, sweep->plan, now, Workers(options.threads));
  const SweepStatus status = sum_up(sweep->plan, runs, now);
  answer("{}", status_text(sweep->head.name, sweep->plan, runs, status));
  return {};
}

Status finalize_sweep(const SweepOptions& options, bool leave_missing) {
  const Result<Begun> sweep = begun_sweep(options.output);
  if (!sweep) return sweep.error();
  const Workers workers(options.threads);
  const auto statuses = all_statuses(options.output, sweep->plan, 0, workers);
  const SweepStatus sum = sum_up(sweep->plan, statuses, 0);
  if (!options.partial) {
    const Status whole = refuse_missing(options.output, sum);
    if (!whole) return leave_missing ? Status() : whole;
  }
  std::vector<FinishedRun> runs(sweep->plan.size());
  workers.for_each(runs.size(), [&](std::size_t i) {
    auto run = finished_run(options.output, sweep->plan[i], statuses[i]);
    runs[i] = run ? std::move(*run) : damaged_run(sweep->plan[i], run.error());
  });
  if (!options.partial) {
    if (Status whole = refuse_damaged(options.output, sweep->plan, runs); !whole) return whole;
  }
  if (Status written = write_tables(options.output, *sweep, runs); !written) return written;
  if (!options.quiet) {
    const auto damaged = std::count_if(runs.begin(), runs.end(), [](const FinishedRun& run) {
      return run.state == RunState::damaged;
    });
    tell("{}: {} and {}: {}, {} of them done\n", options.output.string(), kRunsFile, kIndexFile,
         counted(sum.runs, "run"), sum.done - static_cast<std::size_t>(damaged));
  }
  return {};
}

}  // namespace ensonify
