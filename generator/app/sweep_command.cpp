#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/cost.h"
#include "app/print.h"
#include "app/run_cost.h"
#include "app/version.h"
#include "sweep/expand.h"
#include "sweep/folder.h"
#include "sweep/shards.h"

namespace ensonify {
namespace {

std::string seconds_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.3g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.3g} min", seconds / 60);
  return fmt::format("{:.3g} h", seconds / 3600);
}

void print_row(const SweepRun& run) {
  answer("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", run.id, run.cost.pings, run.cost.files,
         bytes_text(run.cost.disk_bytes), seconds_text(run.cost.core_s), run.name);
}

RunCost sum_of(const Sweep& sweep, const std::vector<std::size_t>& runs) {
  RunCost sum;
  for (const std::size_t run : runs) {
    const RunCost& cost = sweep.runs[run].cost;
    sum.pings += cost.pings;
    sum.files += cost.files;
    sum.disk_bytes += cost.disk_bytes;
    sum.core_s += cost.core_s;
  }
  return sum;
}

std::string without(const Sweep& sweep) {
  std::string text;
  if (sweep.left_out > 0) text += fmt::format(", {} left out by skip_if", sweep.left_out);
  if (sweep.repeated > 0) text += fmt::format(", {} the same as another", sweep.repeated);
  return text;
}

// What is in the folder already; refused is what the sweep itself would refuse.
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
  Result<SweepFile> file = load_sweep_file(options.sweep);
  if (!file) return file.error();
  const Workers workers(options.threads);
  const Result<Sweep> sweep = expand_sweep(std::move(*file), run_cost, workers);
  if (!sweep) return sweep.error();
  const Plan plan = plan_of(*sweep);
  const std::vector<std::size_t> runs = runs_of_shard(plan, options.shard.value_or(Shard{}));
  answer("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", "run", "pings", "files", "disk", "core", "name");
  for (const std::size_t run : runs) print_row(sweep->runs[run]);
  const RunCost sum = sum_of(*sweep, runs);
  const std::string part = options.shard ? fmt::format(" of {} in shard {}/{}", plan.size(),
                                                       options.shard->number, options.shard->count)
                                         : std::string();
  answer("# {}: {} runs{}{}\n", sweep->file.name, runs.size(), part, without(*sweep));
  answer("# {} pings, {} files, about {} on disk and {} of a core\n", sum.pings, sum.files,
         bytes_text(sum.disk_bytes), seconds_text(sum.core_s));
  return options.output.empty() ? Status() : print_change(options, sweep->file.name, plan);
}

}  // namespace ensonify
