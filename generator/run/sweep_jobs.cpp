#include "run/sweep_jobs.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <utility>

#include "core/moments.h"
#include "dataset/work.h"
#include "formats/sha256.h"
#include "ping/prepare_session.h"
#include "ping/scene_warnings.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run/memory.h"
#include "run/memory_room.h"
#include "run/terminal.h"
#include "scenario/text.h"
#include "sweep/folder.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

void warn_once(SweepRoom& room, const SweepRun& run, const std::string& text) {
  const std::lock_guard lock(room.mutex);
  if (!room.warned.insert(text).second) return;
  tell("warning: {} (run {})\n", text, one_line(run.name));
}

Result<BuiltWorld> build(const Crew& crew, const Scenario& scenario) {
  const Turn turn(crew.turns);
  Result<World> world = build_world(scenario, 0);
  if (!world) return world.error();
  give_back_import(*world);
  BuiltWorld built;
  built.world = std::make_shared<const World>(std::move(*world));
  // The tracer refers to its world, so they are kept together.
  struct Both {
    std::shared_ptr<const World> world;
    Tracer tracer;
  };
  const auto both = std::make_shared<const Both>(Both{built.world, Tracer(*built.world)});
  built.tracer = std::shared_ptr<const Tracer>(both, &both->tracer);
  return built;
}

Result<SequenceWorlds> worlds_of(SweepRoom& room, const Job& job) {
  const SweepFile& file = room.file;
  const Point& point = job.run->point;
  const Result<Scenario> scenario = first_scenario_of(file, point);
  if (!scenario) return scenario.error();
  const Result<BuiltWorld> built = room.worlds.world(
      job.world, *scenario, [&](const Scenario& of) { return build(room.crew, of); });
  const Turn turn(room.crew.turns);
  Result<SequenceWorlds> worlds = SequenceWorlds::open_in(
      {[&](SequenceDraw draw, ErrorPlaces places) {
         return scenario_of(file, point, draw, places);
       },
       [&](const Error& error) { return with_place(error, file, point); }, [] { return true; }},
      built);
  if (!worlds) return worlds;
  for (const std::string& warning : worlds->first().world.warnings) {
    warn_once(room, *job.run, warning);
  }
  return worlds;
}

// Memory for the pings of a run. If an upper bound fits, it is used, since counting needs tracing.
MemoryGate::Hold hold_memory(SweepRoom& room, const Session& session, const Backend& backend,
                             int beside) {
  const int threads = room.crew.threads;
  const SynthesisMemory synthesis = backend.memory(!session.world.volumes.empty());
  std::uint64_t bytes =
      peak_bytes(run_memory(session, threads, {}, most_echoes(session), synthesis));
  if (!room.gate.fits(bytes, static_cast<std::uint64_t>(beside))) {
    const Turn turn(room.crew.turns);
    bytes = peak_bytes(
        run_memory(session, threads, {}, count_echoes(session, Tracer(session.world)), synthesis));
  }
  return room.gate.hold(MemoryGate::What::run, bytes);
}

// Keeps the tables while the run is made, because its pipeline asks for them again.
std::shared_ptr<const PipelineTables> tables_of(const Crew& crew, const Session& session) {
  const Turn turn(crew.turns);
  return pipeline_tables(session, crew.numerics);
}

// A run that the device has no room for is made by the processor, as if it had been asked for.
Result<Numerics> numerics_of(SweepRoom& room, const Job& job, const SequenceWorlds& worlds) {
  const Turn turn(room.crew.turns);
  return numerics_that_fit(
      worlds.first(), worlds.first_tracer(), room.crew.numerics,
      [&](std::string_view text) { warn_once(room, *job.run, std::string(text)); });
}

Status check_id(const SweepRun& run, const DatasetWork& work) {
  if (sha256_hex(work.scenario_yaml).starts_with(run.id)) return {};
  return Error{ErrorKind::usage,
               "an input file has changed since the plan was made; restore the file, or repeat the "
               "command to make a new plan"};
}

Status make_job_pings(SweepRoom& room, const Crew& crew, const Job& job,
                      const RunQueue::Taken& taken, const fs::path& dir,
                      const SequenceWorlds& worlds, DatasetWork& work) {
  crew.progress.pings_found(ping_totals(dir, worlds, work).found);
  std::atomic<std::uint64_t> made = 0;
  const auto ping_done = [&] {
    if (++made % job.pings_of_item == 0) room.queue.item_done(taken.run);
  };
  SharedParts first;
  {
    const Turn turn(crew.turns);
    const Workers workers(1);
    const Status settled = settle_display(dir, worlds, crew.numerics, workers, work, first);
    if (!settled) return settled;
  }
  SequenceJob sequences{crew, dir, worlds, work, std::move(first)};
  return make_sequences({&sequences, 1}, taken.beside, ping_done);
}

}  // namespace

Result<std::vector<Job>> jobs_of(const SweepFile& file, const std::vector<const SweepRun*>& runs,
                                 const Workers& workers) {
  std::vector<Job> jobs(runs.size());
  std::vector<Status> statuses(runs.size());
  workers.for_each(runs.size(), [&](std::size_t i) {
    const Result<Scenario> scenario = first_scenario_of(file, runs[i]->point);
    if (!scenario) {
      statuses[i] = scenario.error();
      return;
    }
    const bool blocks = scenario->output.selection.statistics;
    jobs[i] = {runs[i], world_key(*scenario), table_key(*scenario), blocks ? kMomentBlock : 1, 0};
    const std::uint64_t each = runs[i]->cost.pings / scenario->sequences;
    jobs[i].items = scenario->sequences *
                    work_items(static_cast<std::uint32_t>(each), scenario->output.selection);
  });
  for (const Status& status : statuses) {
    if (!status) return status.error();
  }
  std::map<std::string, std::size_t> world, tables;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    world.emplace(jobs[i].world, i);
    tables.emplace(jobs[i].tables, i);
  }
  std::stable_sort(jobs.begin(), jobs.end(), [&](const Job& a, const Job& b) {
    return std::pair(world.at(a.world), tables.at(a.tables)) <
           std::pair(world.at(b.world), tables.at(b.tables));
  });
  return jobs;
}

Status make_run(SweepRoom& room, const Job& job, const RunQueue::Taken& taken) {
  const auto start = std::chrono::steady_clock::now();
  const fs::path dir = room.options.output / run_folder(job.run->id);
  const Result<SequenceWorlds> worlds = worlds_of(room, job);
  if (!worlds) return worlds.error();
  const Session& session = worlds->first();
  const Result<Numerics> numerics = numerics_of(room, job, *worlds);
  if (!numerics) return numerics.error();
  const auto& [settled, threads, turns, progress, stopped, stage_times] = room.crew;
  const Crew crew{*numerics, threads, turns, progress, stopped, stage_times};
  const auto tables = tables_of(crew, session);
  const MemoryGate::Hold memory = hold_memory(room, session, *tables->backend, taken.beside);
  const Workers workers(1);
  Result<DatasetWork> work = settle_dataset(*worlds, {}, {}, crew.numerics, room.hashes);
  if (!work) return work.error();
  if (Status same = check_id(*job.run, *work); !same) return same;
  if (taken.run == 0) {
    const Turn turn(turns);
    for (const auto& text : all_warnings(session, worlds->first_tracer(), workers)) {
      warn_once(room, *job.run, text);
    }
  }
  // A finished run stays, whatever program and machine made it.
  FolderUse use;
  const auto state = open_work(dir, work->identity, session.scenario.sequences,
                               room.options.overwrite, /*keep_sealed=*/true, &use);
  if (!state) return state.error();
  if (*state == FolderState::complete) return {};
  if (Status made = make_job_pings(room, crew, job, taken, dir, *worlds, *work); !made) return made;
  // A run without some of its sequences would distort the comparison of runs.
  const std::vector<SequenceFailure> failed = failures_of(dir, *work);
  if (!failed.empty()) return Error{ErrorKind::usage, failures_text(failed, work->sequences)};
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const auto ended = finish_work(dir, *worlds, std::move(*work), threads, took.count());
  return ended ? Status() : Status(ended.error());
}

}  // namespace ensonify
