#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <new>

#include "core/counted.h"
#include "dataset/layout.h"
#include "formats/files.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run/disk_room.h"
#include "run/make_sequences.h"
#include "run/memory_there.h"
#include "run/options.h"
#include "run/program.h"
#include "run/runs.h"
#include "run/sweep_jobs.h"
#include "run/terminal.h"
#include "scenario/text.h"
#include "sweep/folder.h"
#include "sweep/index.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// The rest is for other programs, and for memory that the estimates do not cover.
constexpr double kMemoryShare = 0.85;
// A disk that cannot store this much is full.
constexpr std::size_t kProbeBytes = 1 << 20;

std::string time_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32] = "";
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

// The results of all lanes.
class Outcome {
 public:
  explicit Outcome(const SweepOptions& options) : options_(options) {}

  // No run can continue, because the device is lost.
  void end(const SweepRun& run, const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!fatal_) fatal_ = named(run, error);
    stopped_ = true;
  }

  void add(const SweepRun& run, const Status& status) {
    const std::lock_guard lock(mutex_);
    if (status) {
      ++done_;
      remove_failure(options_.output, run.id);
    } else if (status.error().kind == ErrorKind::interrupted) {
      interrupted_ = true;
    } else if (const Status recorded = record(run, status.error()); !recorded) {
      if (!fatal_) fatal_ = recorded.error();
      stopped_ = true;
    }
  }

  const std::atomic<bool>& stopped() const { return stopped_; }
  // No further run should start.
  bool ends() const { return stopped_ || interrupted_; }
  std::size_t done() const { return done_; }
  std::size_t failed() const { return failed_; }

  Status result() const {
    if (fatal_) return *fatal_;
    if (!interrupted_) return {};
    return Error{ErrorKind::interrupted,
                 "interrupted: finished work is kept; repeat the command to resume"};
  }

  void tell_failures() const {
    if (failed_ == 0) return;
    tell("error: {} of {} failed; the reasons are in {}\n", failed_,
         counted(failed_ + done_, "run"), (options_.output / "failed").string());
    for (const auto& [message, alike] : failures_) {
      const std::string more = alike.count > 1 ? fmt::format(" and {} more", alike.count - 1) : "";
      tell("  {} (run {}{})\n", message, one_line(alike.first->name), more);
    }
  }

 private:
  static Error named(const SweepRun& run, const Error& error) {
    return {error.kind, fmt::format("{} (run {} {})", error.message, run.id, one_line(run.name))};
  }

  // A disk that stores no files ends the sweep, since every run would fail.
  Status record(const SweepRun& run, const Error& error) {
    if (error.kind == ErrorKind::io && disk_is_full(run)) return named(run, error);
    ++failed_;
    Alike& alike = failures_[error.message];
    // Runs are listed in the order of the sweep, because the first one to fail depends on the
    // threads.
    if (alike.count++ == 0 || &run < alike.first) alike.first = &run;
    return write_failure(options_.output, {run.id, run.name, kind_name(error.kind), error.message,
                                           host_name(), time_utc()});
  }

  bool disk_is_full(const SweepRun& run) const {
    std::error_code unknown;
    const fs::space_info space = fs::space(options_.output, unknown);
    if (!unknown && space.available < run.cost.disk_bytes) return true;
    const std::string probe = layout::kTemporaryFolder + std::string("/probe");
    const Status written =
        write_hashed_file(options_.output, probe, std::string(kProbeBytes, '\0'));
    ::unlink((options_.output / probe).c_str());
    return !written;
  }

  const SweepOptions& options_;
  std::mutex mutex_;
  std::atomic<bool> stopped_ = false;  // ends what is in progress
  std::optional<Error> fatal_;
  std::atomic<bool> interrupted_ = false;
  std::size_t done_ = 0, failed_ = 0;
  // Runs with the same message.
  struct Alike {
    const SweepRun* first = nullptr;
    std::size_t count = 0;
  };
  std::map<std::string, Alike> failures_;
};

Status guarded(SweepRoom& room, const Job& job, const RunQueue::Taken& taken, Outcome& outcome) {
  if (interrupted() || *room.crew.stopped) return Error{ErrorKind::interrupted, "interrupted"};
  try {
    return make_run(room, job, taken);
  } catch (const std::bad_alloc&) {
    return Error{
        ErrorKind::device,
        "not enough memory for this run; repeat the command, with fewer --threads to need less"};
  } catch (const DeviceFailure& failure) {
    outcome.end(*job.run, {ErrorKind::device, failure.what()});
    return Error{ErrorKind::interrupted, "interrupted"};
  } catch (const std::exception& error) {
    return Error{ErrorKind::bug, fmt::format("bug: {}; please report it", error.what())};
  }
}

// The number of remaining jobs of each world.
class WorldUses {
 public:
  explicit WorldUses(const std::vector<Job>& jobs) {
    for (const Job& job : jobs) ++uses_[job.world];
  }
  // Returns whether it was the last one.
  bool drop(const std::string& world) {
    const std::lock_guard lock(mutex_);
    return --uses_.at(world) == 0;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::size_t> uses_;
};

Status make_jobs(const SweepOptions& options, const SweepFile& file, const Numerics& numerics,
                 const std::vector<Job>& jobs, const Workers& workers, Progress& progress,
                 Outcome& outcome) {
  std::vector<std::uint64_t> items;
  for (const Job& job : jobs) items.push_back(job.items);
  RunQueue queue(std::move(items), workers.threads());
  Turns turns(workers.threads());
  const Crew crew{numerics, workers.threads(), turns, progress, &outcome.stopped()};
  MemoryGate gate(
      static_cast<std::uint64_t>(kMemoryShare * static_cast<double>(available_memory())));
  WorldCache worlds(gate);
  WorldUses uses(jobs);
  SweepRoom room{options, file, crew, queue, gate, worlds};
  const int lanes = queue.lanes();
  return in_lanes(lanes, static_cast<std::size_t>(lanes), [&](std::size_t, std::size_t) {
    while (const auto taken = queue.take()) {
      const Job& job = jobs[taken->run];
      // Another process may have been faster.
      if (run_is_done(options.output, job.run->id)) {
        progress.pings_found(job.run->cost.pings);
        outcome.add(*job.run, {});
      } else {
        outcome.add(*job.run, guarded(room, job, *taken, outcome));
      }
      if (outcome.ends()) queue.stop();
      queue.finish(taken->run);
      if (uses.drop(job.world)) worlds.forget(job.world);
    }
    return Status();
  });
}

Result<Shard> shard_of(const SweepOptions& options, std::size_t runs) {
  if (options.shard) return *options.shard;
  const auto shard = slurm_shard([](const char* name) { return std::getenv(name); });
  if (!shard) return shard.error();
  if (!*shard) return Shard{};
  tell("shard {}/{}, from the Slurm array, of {}\n", (*shard)->number, (*shard)->count,
       counted(runs, "run"));
  return **shard;
}

struct ToDo {
  std::vector<const SweepRun*> missing;
  std::uint64_t pings = 0, pings_found = 0;
  std::size_t runs = 0;
};

ToDo to_do(const SweepOptions& options, const Sweep& sweep, const std::vector<std::size_t>& shard) {
  ToDo todo;
  todo.runs = shard.size();
  for (const std::size_t i : shard) {
    const SweepRun& run = sweep.runs[i];
    todo.pings += run.cost.pings;
    if (run_is_done(options.output, run.id)) {
      todo.pings_found += run.cost.pings;
      remove_failure(options.output, run.id);
    } else {
      todo.missing.push_back(&run);
    }
  }
  return todo;
}

Result<std::size_t> make_missing(const SweepOptions& options, const Sweep& sweep,
                                 const Numerics& numerics, const ToDo& todo,
                                 const Workers& workers) {
  const Result<std::vector<Job>> jobs = jobs_of(sweep.file, todo.missing, workers);
  if (!jobs) return jobs.error();
  if (!options.quiet) {
    tell("{}: {} of {} to do, {}\n", options.output.string(), jobs->size(),
         counted(todo.runs, "run"), counted(todo.pings - todo.pings_found, "ping"));
  }
  Outcome outcome(options);
  Status ran;
  {
    Progress progress(progress_style(options.quiet), todo.pings, todo.pings_found);
    ran = make_jobs(options, sweep.file, numerics, *jobs, workers, progress, outcome);
  }
  outcome.tell_failures();
  if (!options.quiet) {
    tell("{}: {} of {} done\n", options.output.string(), todo.runs - jobs->size() + outcome.done(),
         counted(todo.runs, "run"));
  }
  if (!ran) return ran.error();
  const Status result = outcome.result();
  if (!result) return result.error();
  return outcome.failed();
}

}  // namespace

Result<std::size_t> run_sweep(const SweepOptions& options) {
  expect_interrupts();
  Result<SweepFile> file = load_sweep_file(options.sweep, options.overrides);
  if (!file) return file.error();
  const Workers workers(options.threads);
  const Result<Sweep> sweep = expand_sweep(std::move(*file), run_cost, workers);
  if (!sweep) return sweep.error();
  const Plan plan = plan_of(*sweep);
  const Result<Shard> shard = shard_of(options, plan.size());
  if (!shard) return shard.error();
  Result<Numerics> numerics = settled_numerics(options.backend, options.simd, options.quiet);
  if (!numerics) return numerics.error();
  const std::vector<std::size_t> runs = runs_of_shard(plan, *shard);
  const Status room = room_for_runs(options, *sweep, runs);
  if (!room) return room.error();
  listen_for_interrupts();
  const Status opened =
      open_sweep_folder(options.output, {sweep->file.name, program_version(), program_commit()},
                        plan, options.overwrite);
  if (!opened) return opened.error();
  const ToDo todo = to_do(options, *sweep, runs);
  Result<std::size_t> made = std::size_t{0};
  if (!todo.missing.empty()) {
    made = make_missing(options, *sweep, *numerics, todo, workers);
  } else if (!options.quiet) {
    tell("{}: nothing to do: {} of {} done already\n", options.output.string(), todo.runs,
         counted(todo.runs, "run"));
  }
  close_sweep_folder(options.output);
  if (!made || *made > 0) return made;
  // A shard does not know whether it is the last one.
  if (shard->count > 1) {
    if (!options.quiet) {
      tell(
          "{}: when all shards are done, the same command with --finalize instead of --shard "
          "writes their tables\n",
          options.output.string());
    }
    return made;
  }
  // Another process may still be working on some runs, and finishes the sweep then.
  const bool all_done = std::all_of(plan.begin(), plan.end(), [&](const PlannedRun& run) {
    return run_is_done(options.output, run.id);
  });
  const bool is_finished = todo.missing.empty() && has_whole_tables(options.output, plan);
  if (!all_done || is_finished) return made;
  if (Status finished = finalize_sweep(options, true); !finished) return finished.error();
  return made;
}

}  // namespace ensonify
